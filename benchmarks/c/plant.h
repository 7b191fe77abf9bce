/* The plant of the yardstick: one vehicle with its constants, modes and motion. */
#ifndef PLANT_H
#define PLANT_H

#include "yardstick.h"

#include <stdbool.h>

/* What is integrated and feeds back, and what is only summed up. */
typedef struct { double engine, plate, axle, wheel, damper_twist, halfshaft_twist; } Motion;
typedef struct { double distance, engine_work, friction, engine_loss, damper_loss, gear_loss, halfshaft_loss, road_loss; } Sums;

typedef struct {
    /* constant over the launch */
    double slope[32]; /* of the full load, per segment */
    double engine_friction, damper_stiffness, damper_damping, halfshaft_stiffness, halfshaft_damping;
    double drag_constant, drag_slope, filling_speed, filling_exponent, filling_floor;
    double ratio, radius, driving_loss, overrun_loss, grade_torque, rolling_torque, air;
    double engine_inertia, plate_inertia, axle_inertia, vehicle_inertia;
    double per_engine, per_plate, per_both, per_axle, per_vehicle, substep;
    const Vehicle *vehicle;
    /* inputs and modes */
    double effect, capacity, slip_direction, rolling_direction;
    double locked_time;
    bool locked, hill_hold, fits;
    int segment; /* of the full load, where the engine was last */
    double last_speed, last_torque;
    Motion x;
    Sums sums;
} Plant;

/* Stand still at idle, held, with the clutch open, at the throttle that balances the friction; show it in `y`. */
void plant_init(Plant *p, const Vehicle *v, double *y);

/* Take the commands, which then hold until the next call. */
void plant_inputs(Plant *p, double throttle, double clutch_torque);

/* Advance by dt and show the outputs in `y`, one number per channel. */
void plant_step(Plant *p, double dt, double *y);

#endif

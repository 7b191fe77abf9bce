/* The yardstick: the launch of the scenario dct-launch, written by hand in C99.
 *
 * Same equations, integration, events, controller, recording and figures of merit as bitepoint; SI throughout.
 * Vehicle and Calibration lie in memory as bitepoint's records do (every number has 8 bytes), so that Python hands
 * its arrays over as they are; sizes are compared before the first run, results after it. */
#ifndef YARDSTICK_H
#define YARDSTICK_H

#include <stdint.h>

typedef struct { int64_t points; double x[32], y[32]; } Curve;

typedef struct { double mass, wheel_radius, rolling_resistance, drag_coefficient, frontal_area; } Body;
typedef struct {
    double inertia, transient_loss, friction, lag, torque_gain; /* no lag, a gain of 1: neither is used here */
    Curve full_load;
    double drag_constant, drag_slope;
    double filling_gain, filling_throttle_exponent, filling_speed, filling_speed_exponent, filling_speed_floor;
    double idle_speed, speed_limit;
} Engine;
typedef struct { double plate_inertia, torque_limit, torque_rate_limit, friction_gain; } Clutch;
typedef struct { double stiffness, damping; } Shaft;
typedef struct {
    double ratios[8], final_drive, efficiency;
    int64_t gear;
    double odd_shaft_inertia, even_shaft_inertia, layshaft_inertia, axle_inertia;
} Gearbox;
typedef struct { double grade, air_density; } Road;
typedef struct {
    Body body;
    Engine engine;
    Clutch clutch;
    double actuator[13]; /* switched off */
    Shaft damper;
    Gearbox gearbox;
    Shaft halfshaft;
    Road road;
    double substep;
} Vehicle;

typedef struct {
    Curve engine_target;
    double target_rise_time;
    Curve clutch_torque, clutch_rate;
    double touch_delay, clutch_kp, clutch_deadband, clutch_ki, closing_slip, closing_rate, handover_rate, pedal_threshold;
    double kp, ki, kd, throttle_rate_limit;
    double idle_speed, idle_throttle, torque_limit, torque_rate_limit;
} Calibration;

typedef struct {
    int64_t phase;
    double time, feed_forward, integral, clutch_torque;
    double throttle, error, error_before;
} ControllerState;
typedef struct { double pedal, engine_speed, clutch_speed; } Measurement;
typedef struct { double throttle, clutch_torque, engine_speed_target, phase; } Command;

typedef struct {
    int64_t ticks;            /* until the run times out */
    int64_t controller_every; /* ticks between two steps of the controller */
    int64_t rules;            /* 1: stop where launched, stalled or rolled back; 0: run all ticks */
    int64_t locked_hold;      /* ticks that the clutch must have been locked for "launched" */
    double tick;              /* s */
    double stall_speed, rollback_speed;
    const double *pedal;      /* ticks + 1 values */
} Manoeuvre;

enum { RUNNING = -1, TIMED_OUT = -2, NOT_FINITE = -3, LAUNCHED = 0, STALLED = 1, ROLLED_BACK = 2 };

/* Channels of a recording: recording[channel * (ticks + 1) + row]. */
enum {
    PEDAL, ENGINE_SPEED, CLUTCH_SPEED, SLIP_SPEED, INPUT_SHAFT_SPEED, WHEEL_SPEED, VEHICLE_SPEED, VEHICLE_ACCELERATION,
    DISTANCE, ENGINE_TORQUE, CLUTCH_TORQUE, DAMPER_TORQUE, HALFSHAFT_TORQUE, ROAD_TORQUE, CLUTCH_LOCKED,
    CLUTCH_LOCKED_TIME, VEHICLE_HELD,
    ENGINE_WORK, FRICTION_HEAT, LOSSES, STORED_ENERGY, THROTTLE, CLUTCH_TORQUE_COMMAND, ENGINE_SPEED_TARGET,
    LAUNCH_PHASE, CHANNELS
};

/* Figures of merit; NaN where one does not exist. */
enum {
    LAUNCH_TIME, FRICTION_WORK, JERK_PEAK, JERK_PEAK_SETTLED, ENGINE_SPEED_MIN, END_SPEED, ENERGY_RESIDUAL, FIGURES
};

typedef struct { int64_t status, rows; } Outcome;

/* Run one launch into `recording`. */
Outcome run_launch(const Vehicle *vehicle, const Calibration *calibration, const Manoeuvre *m, double *recording);

/* Make the figures of a recording of `rows` rows; `work` has room for rows + 18 numbers. */
void launch_figures(const Manoeuvre *m, const double *recording, int64_t rows, double *work, double *figures);

/* Run `lanes` launches over `threads` threads; figures, lanes x FIGURES, may be NULL. Return 0, or -1 without memory. */
int run_launches(const Vehicle *vehicles, int64_t lanes, const Calibration *calibration, const Manoeuvre *m,
                 int64_t threads, Outcome *outcomes, double *figures);

void controller_init(const Calibration *c, ControllerState *s, Command *out);
void controller_step(const Calibration *c, ControllerState *s, const Measurement *in, Command *out, double dt);

/* Run the controller over a series of measurements, from its initial state on. */
void controller_steps(const Calibration *c, const Measurement *in, Command *out, int64_t count, double dt);

#endif

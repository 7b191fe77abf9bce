/* The plant of the yardstick: a vehicle with a dual-clutch transmission; equations as in bitepoint.plants.dct. */
#include "plant.h"

#include "numerics.h"

#include <math.h>
#include <string.h>

static const double GRAVITY = 9.80665;
static const double STARTING_SPEED = 5.0;   /* rad/s: below it the engine's drag fades */
static const double LOSS_FADE_SPEED = 0.05; /* rad/s: below it the gears' loss fades */
static const double STABILITY = 2.7;        /* longest step times fastest rate */

static inline double sign(double x) { return (x > 0.0) - (x < 0.0); }

typedef struct { double engine, friction, damper, halfshaft, gear_loss, drag, clutch; } Torques;

/* The longest substep at which the driveline is stable. */
static double stable_step(const Plant *p, const Vehicle *v)
{
    const double mobility = p->per_plate + p->ratio * p->ratio * p->per_axle;
    const double decay = 0.5 * p->damper_damping * mobility;
    const double damper = decay + sqrt(fabs(decay * decay - p->damper_stiffness * mobility));
    const double fade = p->overrun_loss * p->ratio * v->clutch.torque_limit / LOSS_FADE_SPEED;
    return STABILITY / (damper + (fade + p->halfshaft_damping) * p->per_axle);
}

static void plant_constants(Plant *p, const Vehicle *v)
{
    const Body *b = &v->body;
    const Engine *e = &v->engine;
    const Gearbox *g = &v->gearbox;
    const double weight = b->mass * GRAVITY * b->wheel_radius / sqrt(1.0 + v->road.grade * v->road.grade);
    const double step = g->ratios[1] / g->ratios[0];
    for (int k = 0; k < e->full_load.points - 1; k++)
        p->slope[k] = (e->full_load.y[k + 1] - e->full_load.y[k]) / (e->full_load.x[k + 1] - e->full_load.x[k]);
    p->engine_friction = e->friction;
    p->damper_stiffness = v->damper.stiffness, p->damper_damping = v->damper.damping;
    p->halfshaft_stiffness = v->halfshaft.stiffness, p->halfshaft_damping = v->halfshaft.damping;
    p->drag_constant = e->drag_constant, p->drag_slope = e->drag_slope;
    p->filling_speed = e->filling_speed, p->filling_exponent = e->filling_speed_exponent;
    p->filling_floor = e->filling_speed_floor;
    p->ratio = g->ratios[g->gear - 1] * g->final_drive;
    p->radius = b->wheel_radius;
    p->driving_loss = 1.0 - g->efficiency, p->overrun_loss = 1.0 / g->efficiency - 1.0;
    p->grade_torque = weight * v->road.grade, p->rolling_torque = weight * b->rolling_resistance;
    p->air = 0.5 * v->road.air_density * b->drag_coefficient * b->frontal_area * pow(b->wheel_radius, 3.0);
    p->engine_inertia = e->inertia + e->transient_loss;
    p->plate_inertia = v->clutch.plate_inertia;
    p->axle_inertia = g->axle_inertia + p->ratio * p->ratio * (g->odd_shaft_inertia
        + g->layshaft_inertia / (g->ratios[0] * g->ratios[0]) + g->even_shaft_inertia * step * step);
    p->vehicle_inertia = b->mass * b->wheel_radius * b->wheel_radius;
    p->per_engine = 1.0 / p->engine_inertia, p->per_plate = 1.0 / p->plate_inertia;
    p->per_both = 1.0 / (p->engine_inertia + p->plate_inertia);
    p->per_axle = 1.0 / p->axle_inertia, p->per_vehicle = 1.0 / p->vehicle_inertia;
    p->substep = fmin(v->substep, stable_step(p, v));
    p->vehicle = v;
}

static inline double engine_drag(const Plant *p, double speed)
{
    return (p->drag_constant + p->drag_slope * fabs(speed)) * clamp(speed / STARTING_SPEED, -1.0, 1.0);
}

static inline double full_load(Plant *p, double speed)
{
    const Curve *c = &p->vehicle->engine.full_load;
    int k = p->segment;
    while (k > 0 && speed < c->x[k]) k--;
    while (k < c->points - 2 && speed >= c->x[k + 1]) k++;
    p->segment = k;
    return c->y[k] + p->slope[k] * (clamp(speed, c->x[0], c->x[c->points - 1]) - c->x[k]);
}

/* The last value is remembered: the end of one substep is the start of the next, and what is shown at a tick. */
static inline double engine_torque(Plant *p, double speed)
{
    if (speed == p->last_speed) return p->last_torque;
    const double drag = engine_drag(p, speed);
    const double ratio = p->filling_speed / (speed > p->filling_floor ? speed : p->filling_floor);
    const double filling = 1.0 - exp(-p->effect * pow(ratio, p->filling_exponent));
    p->last_speed = speed;
    return p->last_torque = (full_load(p, speed) + drag) * filling - drag;
}

static inline Torques torques(Plant *p, const Motion *x)
{
    Torques t;
    t.engine = engine_torque(p, x->engine);
    t.friction = p->engine_friction * x->engine;
    t.damper = p->damper_stiffness * x->damper_twist + p->damper_damping * (x->plate - p->ratio * x->axle);
    t.halfshaft = p->halfshaft_stiffness * x->halfshaft_twist + p->halfshaft_damping * (x->axle - x->wheel);
    const double share = t.damper * x->axle > 0.0 ? p->driving_loss : p->overrun_loss;
    t.gear_loss = share * fabs(p->ratio * t.damper) * clamp(x->axle / LOSS_FADE_SPEED, -1.0, 1.0);
    t.drag = p->air * x->wheel * fabs(x->wheel) + p->rolling_direction * p->rolling_torque;
    t.clutch = p->slip_direction * p->capacity;
    return t;
}

static inline Motion slopes(const Plant *p, const Motion *x, const Torques *t)
{
    Motion d;
    if (p->locked) {
        d.engine = d.plate = (t->engine - t->friction - t->damper) * p->per_both;
    } else {
        d.engine = (t->engine - t->friction - t->clutch) * p->per_engine;
        d.plate = (t->clutch - t->damper) * p->per_plate;
    }
    d.axle = (p->ratio * t->damper - t->gear_loss - t->halfshaft) * p->per_axle;
    d.wheel = p->rolling_direction == 0.0 ? 0.0 : (t->halfshaft - p->grade_torque - t->drag) * p->per_vehicle;
    d.damper_twist = x->plate - p->ratio * x->axle;
    d.halfshaft_twist = x->axle - x->wheel;
    return d;
}

static inline void add_sums(const Plant *p, Sums *s, const Motion *x, const Torques *t, const Motion *d, double h)
{
    s->distance += h * p->radius * x->wheel;
    s->engine_work += h * t->engine * x->engine;
    s->friction += p->locked ? 0.0 : h * t->clutch * (x->engine - x->plate);
    s->engine_loss += h * t->friction * x->engine;
    s->damper_loss += h * p->damper_damping * d->damper_twist * d->damper_twist;
    s->gear_loss += h * t->gear_loss * x->axle;
    s->halfshaft_loss += h * p->halfshaft_damping * d->halfshaft_twist * d->halfshaft_twist;
    s->road_loss += h * t->drag * x->wheel;
}

static inline Motion along(const Motion *x, const Motion *d, double h)
{
    return (Motion){x->engine + h * d->engine, x->plate + h * d->plate, x->axle + h * d->axle, x->wheel + h * d->wheel,
                    x->damper_twist + h * d->damper_twist, x->halfshaft_twist + h * d->halfshaft_twist};
}

/* Classical Runge-Kutta rule of order 4. */
static void integrate(Plant *p, double h)
{
    static const double STAGE[4] = {0.5, 0.5, 1.0, 0.0}, WEIGHT[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const Motion start = p->x;
    Motion x = start, end = start;
    Sums sums = p->sums;
    for (int stage = 0; stage < 4; stage++) {
        const Torques t = torques(p, &x);
        const Motion d = slopes(p, &x, &t);
        add_sums(p, &sums, &x, &t, &d, WEIGHT[stage] * h);
        end = along(&end, &d, WEIGHT[stage] * h);
        x = along(&start, &d, STAGE[stage] * h);
    }
    p->x = end;
    p->sums = sums;
}

/* Torque that the clutch would have to carry to keep engine and plate together. */
static double locked_torque(Plant *p)
{
    const Motion *x = &p->x;
    const double engine = engine_torque(p, x->engine) - p->engine_friction * x->engine;
    const double damper = p->damper_stiffness * x->damper_twist + p->damper_damping * (x->plate - p->ratio * x->axle);
    return damper + p->plate_inertia * p->per_both * (engine - damper);
}

static double wheel_pull(const Plant *p)
{
    const Motion *x = &p->x;
    return p->halfshaft_stiffness * x->halfshaft_twist + p->halfshaft_damping * (x->axle - x->wheel) - p->grade_torque;
}

static bool crossed(Plant *p)
{
    if (p->locked ? fabs(locked_torque(p)) > p->capacity : (p->x.engine - p->x.plate) * p->slip_direction < 0.0)
        return true;
    if (p->rolling_direction != 0.0) return p->x.wheel * p->rolling_direction < 0.0;
    const double pull = wheel_pull(p);
    return pull > p->rolling_torque || (!p->hill_hold && pull < -p->rolling_torque);
}

static void switch_modes(Plant *p)
{
    Motion *x = &p->x;
    const bool locked = p->locked;
    if (p->locked) {
        const double torque = locked_torque(p);
        if (fabs(torque) > p->capacity) p->locked = false, p->slip_direction = sign(torque);
    } else if ((x->engine - x->plate) * p->slip_direction <= 0.0) {
        x->engine = x->plate = (p->engine_inertia * x->engine + p->plate_inertia * x->plate) * p->per_both;
        const double torque = locked_torque(p);
        p->locked = fabs(torque) <= p->capacity;
        if (!p->locked) p->slip_direction = sign(torque);
    }
    if (p->locked != locked) p->locked_time = 0.0;
    if (x->wheel * p->rolling_direction < 0.0) x->wheel = 0.0, p->rolling_direction = 0.0;
    if (p->rolling_direction == 0.0) {
        const double pull = wheel_pull(p);
        if (pull > p->rolling_torque)
            p->rolling_direction = 1.0, p->hill_hold = false;
        else if (!p->hill_hold && pull < -p->rolling_torque)
            p->rolling_direction = -1.0;
    }
}

/* Integrate over h, or to the first event before it; return the time that went by. */
static double advance(Plant *p, double h)
{
    const Motion start = p->x;
    const Sums sums = p->sums;
    integrate(p, h);
    p->fits = !crossed(p);
    if (p->fits) return h;
    double before = 0.0, passed = h;
    for (int bisection = 0; bisection < 40; bisection++) {
        const double middle = 0.5 * (before + passed);
        p->x = start, p->sums = sums;
        integrate(p, middle);
        if (crossed(p)) passed = middle;
        else before = middle;
    }
    p->x = start, p->sums = sums;
    integrate(p, passed);
    return passed;
}

static void substep(Plant *p, double h)
{
    double left = h;
    for (int event = 0; event < 8 && left > 0.0; event++) {
        if (!p->fits) switch_modes(p); /* modes that fitted at the end of the last substep still do */
        const double passed = advance(p, left);
        if (p->locked) p->locked_time += passed;
        left -= passed;
    }
    if (left > 0.0) integrate(p, left), p->fits = false;
}

/* Write the outputs into one row of the signals. */
static void observe(Plant *p, double *y)
{
    const Motion x = p->x;
    const Sums *s = &p->sums;
    const Torques t = torques(p, &x);
    const Motion d = slopes(p, &x, &t);
    const double net = t.engine - t.friction;
    y[ENGINE_SPEED] = x.engine;
    y[CLUTCH_SPEED] = x.plate;
    y[SLIP_SPEED] = x.engine - x.plate;
    y[INPUT_SHAFT_SPEED] = p->ratio * x.axle;
    y[WHEEL_SPEED] = x.wheel;
    y[VEHICLE_SPEED] = p->radius * x.wheel;
    y[VEHICLE_ACCELERATION] = p->radius * d.wheel;
    y[DISTANCE] = s->distance;
    y[ENGINE_TORQUE] = t.engine - p->vehicle->engine.transient_loss * d.engine;
    y[CLUTCH_TORQUE] = p->locked ? t.damper + p->plate_inertia * p->per_both * (net - t.damper) : t.clutch;
    y[DAMPER_TORQUE] = t.damper;
    y[HALFSHAFT_TORQUE] = t.halfshaft;
    y[ROAD_TORQUE] = t.halfshaft - p->vehicle_inertia * d.wheel;
    y[CLUTCH_LOCKED] = p->locked;
    y[CLUTCH_LOCKED_TIME] = p->locked_time;
    y[VEHICLE_HELD] = p->rolling_direction == 0.0;
    y[ENGINE_WORK] = s->engine_work;
    y[FRICTION_HEAT] = s->friction;
    y[LOSSES] = s->engine_loss + s->damper_loss + s->gear_loss + s->halfshaft_loss + s->road_loss;
    y[STORED_ENERGY] = 0.5 * (p->engine_inertia * x.engine * x.engine + p->plate_inertia * x.plate * x.plate
        + p->axle_inertia * x.axle * x.axle + p->vehicle_inertia * x.wheel * x.wheel
        + p->damper_stiffness * x.damper_twist * x.damper_twist
        + p->halfshaft_stiffness * x.halfshaft_twist * x.halfshaft_twist) + p->grade_torque * s->distance / p->radius;
}

void plant_inputs(Plant *p, double throttle, double clutch_torque)
{
    const Vehicle *v = p->vehicle;
    p->effect = v->engine.filling_gain * pow(clamp(throttle, 0.0, 1.0), v->engine.filling_throttle_exponent);
    p->capacity = v->clutch.friction_gain * clamp(clutch_torque, 0.0, v->clutch.torque_limit);
    p->last_speed = NAN;
    p->fits = false;
}

static double throttle_for(const Plant *p, double torque, double speed)
{
    const Engine *e = &p->vehicle->engine;
    const double drag = engine_drag(p, speed);
    const double most = lookup(&e->full_load, speed) + drag;
    const double filling = clamp((torque + drag) / (most > 1e-9 ? most : 1e-9), 0.0, 1.0 - 1e-12);
    const double floor = speed > e->filling_speed_floor ? speed : e->filling_speed_floor;
    const double gain = e->filling_gain * pow(e->filling_speed / floor, e->filling_speed_exponent);
    return clamp(pow(-log(1.0 - filling) / gain, 1.0 / e->filling_throttle_exponent), 0.0, 1.0);
}

void plant_init(Plant *p, const Vehicle *v, double *y)
{
    memset(p, 0, sizeof *p);
    plant_constants(p, v);
    p->x.engine = v->engine.idle_speed;
    p->hill_hold = true;
    p->slip_direction = 1.0;
    plant_inputs(p, throttle_for(p, p->engine_friction * p->x.engine, p->x.engine), 0.0);
    observe(p, y);
}

void plant_step(Plant *p, double dt, double *y)
{
    const int substeps = (int)clamp(dt / p->substep + 0.999, 1.0, 1e5);
    const double h = dt / substeps;
    for (int i = 0; i < substeps; i++) substep(p, h);
    if (!p->fits) switch_modes(p);
    observe(p, y);
}

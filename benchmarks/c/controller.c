/* The controller of the yardstick: launch at constant engine speed, as in bitepoint.controllers.launch_pid. */
#include "numerics.h"
#include "yardstick.h"

#include <math.h>

enum { WAITING, SLIPPING, CLOSING, DRIVING };

static int64_t next_phase(const Calibration *c, const ControllerState *s, double pedal, double slip)
{
    if (pedal <= c->pedal_threshold && s->phase < CLOSING) return WAITING;
    switch (s->phase) {
    case WAITING: return SLIPPING;
    case SLIPPING: return s->time > c->touch_delay && slip < c->closing_slip ? CLOSING : SLIPPING;
    case CLOSING: return slip <= 0.0 ? DRIVING : CLOSING;
    default: return s->phase;
    }
}

static double slipping_torque(const Calibration *c, ControllerState *s, double pedal, double speed_error, double dt)
{
    if (s->time < c->touch_delay) return 0.0;
    const double error = speed_error - clamp(speed_error, -c->clutch_deadband, c->clutch_deadband);
    const double goal = lookup(&c->clutch_torque, pedal), rise = lookup(&c->clutch_rate, pedal) * dt;
    s->feed_forward = clamp(goal, s->feed_forward - rise, s->feed_forward + rise);
    s->integral = clamp(s->integral - c->clutch_ki * dt * error, -s->feed_forward, 10000.0);
    return s->feed_forward + s->integral - c->clutch_kp * error;
}

/* PID on the throttle rate, in velocity form. */
static double engine_speed_control(const Calibration *c, ControllerState *s, double target, double speed, double dt)
{
    const double error = clamp(target - speed, -2000.0, 2000.0), most = c->throttle_rate_limit * dt;
    const double change = c->kp * (error - s->error) + c->ki * dt * error
        + c->kd * (error - 2.0 * s->error + s->error_before) / dt;
    s->throttle = clamp(s->throttle + clamp(change, -most, most), 0.0, 1.0);
    s->error_before = s->error;
    s->error = error;
    return s->throttle;
}

void controller_init(const Calibration *c, ControllerState *s, Command *out)
{
    *s = (ControllerState){.phase = WAITING, .throttle = clamp(c->idle_throttle, 0.0, 1.0)};
    *out = (Command){.throttle = c->idle_throttle, .engine_speed_target = c->idle_speed};
}

void controller_step(const Calibration *c, ControllerState *s, const Measurement *in, Command *out, double dt)
{
    if (!isfinite(in->pedal) || !isfinite(in->engine_speed) || !isfinite(in->clutch_speed)) return;
    const double pedal = clamp(in->pedal, 0.0, 1.0);
    s->phase = next_phase(c, s, pedal, in->engine_speed - in->clutch_speed);
    const double risen = clamp(s->time / c->target_rise_time, 0.0, 1.0);
    double target = c->idle_speed + risen * (lookup(&c->engine_target, pedal) - c->idle_speed);
    double torque = 0.0;
    if (s->phase == WAITING) {
        s->time = s->feed_forward = s->integral = 0.0;
        target = c->idle_speed;
    } else if (s->phase == SLIPPING) {
        torque = slipping_torque(c, s, pedal, target - in->engine_speed, dt);
        s->time += dt;
    } else {
        torque = s->clutch_torque + c->closing_rate * dt;
    }
    const double most = c->torque_rate_limit * dt;
    s->clutch_torque = clamp(clamp(torque, s->clutch_torque - most, s->clutch_torque + most), 0.0, c->torque_limit);
    if (s->phase == DRIVING) {
        const double change = c->handover_rate * dt;
        out->throttle = s->throttle = clamp(pedal, s->throttle - change, s->throttle + change);
    } else {
        out->throttle = engine_speed_control(c, s, target, in->engine_speed, dt);
    }
    out->clutch_torque = s->clutch_torque;
    out->engine_speed_target = target;
    out->phase = (double)s->phase;
}

void controller_steps(const Calibration *c, const Measurement *in, Command *out, int64_t count, double dt)
{
    ControllerState s;
    controller_init(c, &s, out);
    for (int64_t n = 0; n < count; n++) controller_step(c, &s, &in[n], &out[n], dt);
}

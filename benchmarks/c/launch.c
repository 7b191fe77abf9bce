/* The closed loop of the yardstick: one launch, and many of them over threads. */
#include "plant.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

static bool all_finite(const double *y)
{
    double total = 0.0;
    for (int channel = 0; channel < CHANNELS; channel++) total += fabs(y[channel]);
    return isfinite(total);
}

static void show(const Command *command, double *y)
{
    y[THROTTLE] = command->throttle;
    y[CLUTCH_TORQUE_COMMAND] = command->clutch_torque;
    y[ENGINE_SPEED_TARGET] = command->engine_speed_target;
    y[LAUNCH_PHASE] = command->phase;
}

/* A tick is: pedal, controller, recording, stop rules, plant. */
Outcome run_launch(const Vehicle *vehicle, const Calibration *calibration, const Manoeuvre *m, double *recording)
{
    const double period = m->tick * (double)m->controller_every;
    const int64_t rows = m->ticks + 1;
    double y[CHANNELS];
    Plant plant;
    ControllerState state;
    Command command;
    int64_t locked = 0;
    Outcome outcome = {RUNNING, 0};

    plant_init(&plant, vehicle, y);
    controller_init(calibration, &state, &command);
    for (int64_t tick = 0; tick < rows; tick++) {
        y[PEDAL] = m->pedal[tick];
        if (tick % m->controller_every == 0) {
            const Measurement in = {y[PEDAL], y[ENGINE_SPEED], y[CLUTCH_SPEED]};
            controller_step(calibration, &state, &in, &command, period);
            plant_inputs(&plant, command.throttle, command.clutch_torque);
            show(&command, y);
        }
        for (int channel = 0; channel < CHANNELS; channel++) recording[channel * rows + tick] = y[channel];
        outcome.rows = tick + 1;
        locked = y[CLUTCH_LOCKED] > 0.5 ? locked + 1 : 0;
        if (!all_finite(y)) outcome.status = NOT_FINITE;
        else if (m->rules && locked > m->locked_hold) outcome.status = LAUNCHED;
        else if (m->rules && y[ENGINE_SPEED] < m->stall_speed) outcome.status = STALLED;
        else if (m->rules && y[VEHICLE_SPEED] < m->rollback_speed) outcome.status = ROLLED_BACK;
        else if (tick == m->ticks) outcome.status = TIMED_OUT;
        if (outcome.status != RUNNING) break;
        plant_step(&plant, m->tick, y);
    }
    return outcome;
}

typedef struct {
    const Vehicle *vehicles;
    const Calibration *calibration;
    const Manoeuvre *manoeuvre;
    Outcome *outcomes;
    double *figures;
    int64_t lanes;
    atomic_llong next;
    atomic_int failed;
} Batch;

/* Take one lane after the other until there are none left; the thread's memory is used again for each. */
static void *work_off(void *argument)
{
    Batch *b = argument;
    const size_t rows = (size_t)b->manoeuvre->ticks + 1;
    double *recording = malloc((CHANNELS + 1) * rows * sizeof *recording + 32 * sizeof *recording);
    if (!recording) {
        b->failed = 1;
        return NULL;
    }
    double *work = recording + CHANNELS * rows;
    for (int64_t n = b->next++; n < b->lanes; n = b->next++) {
        b->outcomes[n] = run_launch(&b->vehicles[n], b->calibration, b->manoeuvre, recording);
        if (b->figures)
            launch_figures(b->manoeuvre, recording, b->outcomes[n].rows, work, b->figures + FIGURES * n);
    }
    free(recording);
    return NULL;
}

int run_launches(const Vehicle *vehicles, int64_t lanes, const Calibration *calibration, const Manoeuvre *m,
                 int64_t threads, Outcome *outcomes, double *figures)
{
    enum { MOST_THREADS = 256 };
    Batch b = {vehicles, calibration, m, outcomes, figures, lanes, 0, 0};
    pthread_t others[MOST_THREADS];
    int64_t started = 0;
    while (started + 1 < threads && started < MOST_THREADS && !pthread_create(&others[started], NULL, work_off, &b))
        started++;
    work_off(&b);
    for (int64_t n = 0; n < started; n++) pthread_join(others[n], NULL);
    return b.failed ? -1 : 0;
}

const int64_t yardstick_sizes[4] = {sizeof(Vehicle), sizeof(Calibration), sizeof(Measurement), sizeof(Command)};

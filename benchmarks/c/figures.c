/* The figures of merit of the yardstick; definitions as in bitepoint.metrics. */
#include "yardstick.h"

#include <math.h>

static const double PEDAL_THRESHOLD = 0.01;
static const double SETTLING_TIME = 0.5;    /* s, after sync */
static const double JERK_SAMPLING = 100.0;  /* Hz */
static const double JERK_CUTOFF = 10.0;     /* Hz */
enum { PADDING = 9 };

/* A channel at any time within the recording, linear between its rows. */
static inline double at(const double *channel, int64_t rows, double tick, double time)
{
    int64_t k = (int64_t)(time / tick);
    if (k > rows - 2) k = rows - 2;
    const double share = time / tick - (double)k;
    return channel[k] + (share < 1.0 ? share : 1.0) * (channel[k + 1] - channel[k]);
}

/* The time at which the slip first reaches 0 after the onset; NaN for never. */
static double sync_time(const double *engine, const double *clutch, const double *locked_time, int64_t rows, double tick,
                        double onset)
{
    for (int64_t k = 1; k < rows; k++) {
        const double slip = engine[k] - clutch[k], before = engine[k - 1] - clutch[k - 1];
        if (tick * (double)k <= onset || before == 0.0 || slip * before > 0.0) continue;
        if (slip == 0.0) return tick * (double)k - locked_time[k];
        return tick * ((double)(k - 1) + before / (before - slip));
    }
    return NAN;
}

/* Butterworth filter of order 2, in place, from the steady state of its first sample on; k = tan(pi f / fs). */
static void biquad(double *x, int64_t count, int64_t step, double k)
{
    const double norm = 1.0 / (1.0 + sqrt(2.0) * k + k * k), b = k * k * norm;
    const double a1 = 2.0 * (k * k - 1.0) * norm, a2 = (1.0 - sqrt(2.0) * k + k * k) * norm;
    double z1 = (1.0 - b) * *x, z2 = (b - a2) * *x;
    for (int64_t n = 0; n < count; n++, x += step) {
        const double y = b * *x + z1;
        z1 = 2.0 * b * *x - a1 * y + z2;
        z2 = b * *x - a2 * y;
        *x = y;
    }
}

/* The largest magnitude of the jerk until `end`: speed at 100 Hz, differenced twice, filtered both ways. */
static double jerk_peak(const double *speed, int64_t rows, double tick, double end, double *work)
{
    const int64_t count = (int64_t)floor(end * JERK_SAMPLING + 1e-6) - 1;
    if (count < 1) return NAN;
    const int64_t pad = count - 1 < PADDING ? count - 1 : PADDING;
    double *jerk = work + pad, peak = 0.0;
    double before = at(speed, rows, tick, 0.0), now = at(speed, rows, tick, 1.0 / JERK_SAMPLING);
    for (int64_t n = 0; n < count; n++) {
        const double next = at(speed, rows, tick, (double)(n + 2) / JERK_SAMPLING);
        jerk[n] = (next - 2.0 * now + before) * JERK_SAMPLING * JERK_SAMPLING;
        before = now, now = next;
    }
    if (count >= 2) {
        for (int64_t n = 0; n < pad; n++) {
            work[n] = 2.0 * jerk[0] - jerk[pad - n];
            jerk[count + n] = 2.0 * jerk[count - 1] - jerk[count - 2 - n];
        }
        const double k = tan(3.14159265358979323846 * JERK_CUTOFF / JERK_SAMPLING);
        biquad(work, count + 2 * pad, 1, k);
        biquad(work + count + 2 * pad - 1, count + 2 * pad, -1, k);
    }
    for (int64_t n = 0; n < count; n++) peak = fmax(peak, fabs(jerk[n]));
    return peak;
}

static double energy_residual(const double *recording, int64_t size, int64_t rows)
{
    static const int PLACES[4] = {ENGINE_WORK, FRICTION_HEAT, LOSSES, STORED_ENERGY};
    double change[4];
    for (int n = 0; n < 4; n++) change[n] = recording[PLACES[n] * size + rows - 1] - recording[PLACES[n] * size];
    return change[0] != 0.0 ? fabs(change[0] - change[1] - change[2] - change[3]) / fabs(change[0]) : NAN;
}

void launch_figures(const Manoeuvre *m, const double *recording, int64_t rows, double *work, double *figures)
{
    const int64_t size = m->ticks + 1;
    const double *engine = recording + ENGINE_SPEED * size, *speed = recording + VEHICLE_SPEED * size;
    const double *heat = recording + FRICTION_HEAT * size;
    const double last = m->tick * (double)(rows - 1);
    for (int n = 0; n < FIGURES; n++) figures[n] = NAN;
    if (rows < 2) return;
    figures[ENERGY_RESIDUAL] = energy_residual(recording, size, rows);
    int64_t pressed = 0;
    while (pressed < rows && recording[PEDAL * size + pressed] <= PEDAL_THRESHOLD) pressed++;
    if (pressed == rows) return;
    const double *pedal = recording + PEDAL * size;
    const int64_t before = pressed > 0 ? pressed - 1 : 0;
    const double share = pressed > 0 ? (PEDAL_THRESHOLD - pedal[before]) / (pedal[pressed] - pedal[before]) : 0.0;
    const double start = m->tick * ((double)before + share);
    const double *locked_time = recording + CLUTCH_LOCKED_TIME * size;
    const double sync = sync_time(engine, recording + CLUTCH_SPEED * size, locked_time, rows, m->tick, start);
    const double until = isnan(sync) ? last : sync + SETTLING_TIME;
    double least = INFINITY;
    for (int64_t k = (int64_t)ceil(start / m->tick - 1e-9); k < rows && m->tick * (double)k <= until; k++) least = engine[k] < least ? engine[k] : least;
    figures[ENGINE_SPEED_MIN] = least;
    if (isnan(sync)) return;
    figures[LAUNCH_TIME] = sync - start;
    figures[FRICTION_WORK] = at(heat, rows, m->tick, sync) - at(heat, rows, m->tick, start);
    figures[JERK_PEAK] = jerk_peak(speed, rows, m->tick, sync, work);
    figures[END_SPEED] = at(speed, rows, m->tick, sync);
    if (until <= last) figures[JERK_PEAK_SETTLED] = fmax(figures[JERK_PEAK], jerk_peak(speed, rows, m->tick, until, work));
}

/* Small functions that plant and controller share. */
#ifndef NUMERICS_H
#define NUMERICS_H

#include "yardstick.h"

static inline double clamp(double x, double low, double high) { return x > low ? (x < high ? x : high) : low; }

/* Linear between the points of a curve, constant beyond them. */
static inline double lookup(const Curve *c, double x)
{
    int k = 0;
    while (k < c->points - 2 && x >= c->x[k + 1]) k++;
    const double share = clamp((x - c->x[k]) / (c->x[k + 1] - c->x[k]), 0.0, 1.0);
    return c->y[k] + share * (c->y[k + 1] - c->y[k]);
}

#endif

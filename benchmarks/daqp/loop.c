/* A loop over quadratic programmes of one Hessian, solved by DAQP from a cold start: for benchmarks/qp.py. */
#include <stdlib.h>

#include "api.h"
#include "auxiliary.h"
#include "utils.h"

/* Set up DAQP for n variables and m rows; returns NULL where it refuses. */
void *loop_new(int n, int m, double *hessian, double *gradient, double *rows, double *low, double *high)
{
    DAQPProblem *problem = calloc(1, sizeof(DAQPProblem));
    DAQPWorkspace *work = calloc(1, sizeof(DAQPWorkspace));
    problem->n = n;
    problem->m = m;
    problem->H = hessian;
    problem->f = gradient;
    problem->A = rows;
    problem->blower = low;
    problem->bupper = high;
    return setup_daqp(problem, work, NULL) < 0 ? NULL : work;
}

/* Solve `count` programmes; x of each into x, shape (count, n). Returns how many were not solved. */
int loop_run(void *handle, int count, double *gradients, double *lows, double *highs, double *x, double *multipliers)
{
    DAQPWorkspace *work = handle;
    DAQPProblem *problem = work->qp;
    DAQPResult result = {0};
    int failed = 0;
    for (int k = 0; k < count; k++) {
        problem->f = gradients + (size_t)k * problem->n;
        problem->blower = lows + (size_t)k * problem->m;
        problem->bupper = highs + (size_t)k * problem->m;
        daqp_deactivate_constraints(work);
        if (daqp_update_ldp(DAQP_UPDATE_v | DAQP_UPDATE_d, work, problem) < 0) {
            failed++;
            continue;
        }
        result.x = x + (size_t)k * problem->n;
        result.lam = multipliers;
        daqp_solve(&result, work);
        failed += result.exitflag != 1;
    }
    return failed;
}

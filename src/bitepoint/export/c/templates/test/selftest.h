/* Recorded vectors, stepped through and compared word by word. */
#ifndef SELFTEST_H
#define SELFTEST_H

#include <stdbool.h>
#include <stdint.h>

typedef struct
{
    uint32_t sequences;
    uint32_t steps;
    uint32_t differences;      /* words that are not what they were when recorded */
    uint32_t first_difference; /* number of the step that has the first one, counted from 1 over all sequences */
} selftest_result_t;

selftest_result_t selftest_run(void);

/* Called around every step, for whoever measures. */
void selftest_begin(void);
void selftest_end(bool designed); /* whether the parameters are those that were designed, and no random ones */

#endif

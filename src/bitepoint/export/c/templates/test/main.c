/* The self-test on a computer. */
#include "@prefix@.h"
#include "selftest.h"

#include <stdio.h>

void selftest_begin(void)
{
    /* nothing to measure here */
}

void selftest_end(bool designed)
{
    (void)designed;
    /* nothing to measure here */
}

int main(void)
{
    const selftest_result_t result = selftest_run();
    (void)printf("@name@ %s: %u steps in %u sequences, %u differences\n", @prefix@_version(), (unsigned)result.steps,
        (unsigned)result.sequences, (unsigned)result.differences);
    if (result.differences > 0U)
    {
        (void)printf("the first one in step %u\n", (unsigned)result.first_difference);
    }
    return (result.differences == 0U) ? 0 : 1;
}

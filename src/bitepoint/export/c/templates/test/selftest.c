/* See selftest.h. */
#include "selftest.h"
#include "vectors.h"

#include <math.h>
#include <string.h>

@instances@

#define TOLERANCE (@tolerance@)
/* 0: every bit has to be right. Above it: what may be missing, relative to the larger of the value and 1, where
 * functions of the maths library are in use, which libraries round differently in the last place. */

/* Whether two floats are the same number, or both none. */
static bool same(@real@ got, @real@ expected)
{
    const double distance = fabs((double)got - (double)expected);
    const bool close = (TOLERANCE > 0.0) && (distance <= (TOLERANCE * fmax(1.0, fabs((double)expected))));
    return (memcmp(&got, &expected, sizeof(got)) == 0) || (isnan(got) && isnan(expected)) || close;
}

static void note(selftest_result_t *result)
{
    if (result->differences == 0U)
    {
        result->first_difference = result->steps;
    }
    result->differences++;
}

/* Compare word by word; `whole` says which words are integers, NULL: none. */
static void compare(
    const void *got, const void *expected, size_t bytes, const bool *whole, selftest_result_t *result)
{
    @real@ values[2];
    for (size_t place = 0U; place < bytes; place += sizeof(values[0]))
    {
        (void)memcpy(&values[0], (const char *)got + place, sizeof(values[0]));
        (void)memcpy(&values[1], (const char *)expected + place, sizeof(values[1]));
        const bool equal = (memcmp(&values[0], &values[1], sizeof(values[0])) == 0);
        const bool number = (whole == NULL) || !whole[place / sizeof(values[0])];
        if (!equal && !(number && same(values[0], values[1])))
        {
            note(result);
        }
    }
}

selftest_result_t selftest_run(void)
{
    selftest_result_t result = {0U, 0U, 0U, 0U};
    uint32_t row = 0U;
    for (uint32_t n = 0U; n < VECTORS_SEQUENCES; n++)
    {
        const vectors_sequence_t *const sequence = &vectors_sequences[n];
@clear@
        (void)memcpy(&@inputs@, vectors_inputs[row], sizeof(@inputs@));
        @prefix@_init(@init_arguments@);
        compare(&@outputs@, vectors_outputs[row], sizeof(@outputs@), NULL, &result);
        row++;
        for (uint32_t k = 1U; k < sequence->rows; k++)
        {
            (void)memcpy(&@inputs@, vectors_inputs[row], sizeof(@inputs@));
            result.steps++;
            selftest_begin();
            const @integer@ status = @prefix@_step(@step_arguments@);
            selftest_end(sequence->designed);
            compare(&@outputs@, vectors_outputs[row], sizeof(@outputs@), NULL, &result);
            if (status != vectors_status[row])
            {
                note(&result);
            }
            row++;
        }
        compare(&@state@, &sequence->state, sizeof(@state@), vectors_whole, &result);
        result.sequences++;
    }
    return result;
}

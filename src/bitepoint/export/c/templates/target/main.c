/* The self-test on a bare-metal image: answers compared, instructions and stack of every step measured.
 *
 * An emulator that gives each instruction the same time (QEMU's -icount) makes SysTick count instructions. Its clock
 * has NANOSECONDS_PER_TICK, an instruction takes NANOSECONDS_PER_INSTRUCTION. It has 24 bits, enough for 10 million
 * instructions; a longer step is not counted, and said to be too long.
 *
 * The stack is that below the caller of a step. selftest_begin paints it, and selftest_end looks how far the paint is
 * gone: both without stack of their own, as far as the compiler lets them. What they do take is the floor, the least
 * that can be seen. */
#include "selftest.h"
#include "semihosting.h"

#include <stdint.h>

#define NANOSECONDS_PER_TICK (40U)
#define NANOSECONDS_PER_INSTRUCTION (64U)
#define PAINTED_WORDS (2048U)
#define PAINT (0xA5A5A5A5U)
#define TICKS (0x00FFFFFFU)
#define CAME_TO_ZERO (1UL << 16)

static volatile uint32_t *const systick = (volatile uint32_t *)0xE000E010U; /* control, reload, value */

static volatile uint32_t *stack_base;
static uint32_t overhead;
static struct
{
    uint32_t steps;
    uint32_t too_long;
    uint32_t worst;
    uint32_t worst_of_random;
    uint32_t stack;
    uint64_t total;
} seen;

__attribute__((noinline)) void selftest_begin(void)
{
    volatile uint32_t *end;
    __asm__ volatile("mov %0, sp" : "=r"(end));
    stack_base = (volatile uint32_t *)__builtin_dwarf_cfa();
    for (volatile uint32_t *word = stack_base - PAINTED_WORDS; word < end; word++)
    {
        *word = PAINT;
    }
    systick[2] = 0U; /* begins anew, and forgets that it ever came to zero */
}

static __attribute__((noinline)) void note(bool designed, uint32_t ticks, uint32_t control, uint32_t stack)
{
    const uint32_t spent = ((ticks * NANOSECONDS_PER_TICK) + (NANOSECONDS_PER_INSTRUCTION / 2U)) / NANOSECONDS_PER_INSTRUCTION;
    const uint32_t instructions = (spent > overhead) ? (spent - overhead) : 0U;
    uint32_t *const worst = designed ? &seen.worst : &seen.worst_of_random;
    seen.steps++;
    seen.stack = (stack > seen.stack) ? stack : seen.stack;
    if ((control & CAME_TO_ZERO) != 0U)
    {
        seen.too_long++;
    }
    else
    {
        *worst = (instructions > *worst) ? instructions : *worst;
        seen.total += instructions;
    }
}

__attribute__((noinline)) void selftest_end(bool designed)
{
    const uint32_t ticks = (0U - systick[2]) & TICKS;
    const uint32_t control = systick[0];
    const volatile uint32_t *word = stack_base - PAINTED_WORDS;
    while ((word < stack_base) && (*word == PAINT))
    {
        word++;
    }
    note(designed, ticks, control, (uint32_t)(stack_base - word) * 4U);
}

static void show(const char *name, uint32_t number)
{
    semihosting_text(name);
    semihosting_text("=");
    semihosting_number(number);
    semihosting_text("\n");
}

int main(void)
{
    systick[1] = TICKS;
    systick[2] = 0U;
    systick[0] = 5U;
    selftest_begin();
    selftest_end(true);
    overhead = seen.worst;
    const uint32_t floor = seen.stack;
    seen.steps = 0U;
    seen.worst = 0U;
    seen.stack = 0U;
    seen.total = 0U;
    const selftest_result_t result = selftest_run();
    show("sequences", result.sequences);
    show("steps", result.steps);
    show("differences", result.differences);
    show("first_difference", result.first_difference);
    show("steps_too_long", seen.too_long);
    show("instructions_worst", seen.worst);
    show("instructions_worst_of_random", seen.worst_of_random);
    show("instructions_mean", (seen.steps > seen.too_long) ? (uint32_t)(seen.total / (seen.steps - seen.too_long)) : 0U);
    show("stack_measured", seen.stack);
    show("stack_floor", floor);
    return (result.differences == 0U) ? 0 : 1;
}

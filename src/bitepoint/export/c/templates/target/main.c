/* The self-test on a bare-metal image: answers compared, instructions and stack of every step measured.
 *
 * An emulator that gives each instruction the same time (QEMU's -icount) makes SysTick count instructions. Its clock
 * has NANOSECONDS_PER_TICK, an instruction takes NANOSECONDS_PER_INSTRUCTION. */
#include "selftest.h"
#include "semihosting.h"

#include <stdint.h>

#define NANOSECONDS_PER_TICK (40U)
#define NANOSECONDS_PER_INSTRUCTION (64U)
#define PAINTED_WORDS (2048U)
#define PAINT (0xA5A5A5A5U)

static volatile uint32_t *const systick = (volatile uint32_t *)0xE000E010U; /* control, reload, value */

static uint32_t overhead;
static uint32_t begun;
static uint32_t worst;
static uint32_t steps;
static uint64_t total;
static volatile uint32_t *stack_base;
static uint32_t stack_worst;

static void paint(void)
{
    volatile uint32_t *word = stack_base - PAINTED_WORDS;
    volatile uint32_t *const end = (volatile uint32_t *)__builtin_frame_address(0) - 8;
    for (; word < end; word++)
    {
        *word = PAINT;
    }
}

__attribute__((noinline)) void selftest_begin(void)
{
    stack_base = (volatile uint32_t *)__builtin_frame_address(0) + 2;
    paint();
    begun = systick[2];
}

__attribute__((noinline)) void selftest_end(void)
{
    const uint32_t ticks = (begun - systick[2]) & 0x00FFFFFFU;
    const uint32_t spent = ((ticks * NANOSECONDS_PER_TICK) + (NANOSECONDS_PER_INSTRUCTION / 2U)) / NANOSECONDS_PER_INSTRUCTION;
    const uint32_t instructions = (spent > overhead) ? (spent - overhead) : 0U;
    const volatile uint32_t *word = stack_base - PAINTED_WORDS;
    while ((word < stack_base) && (*word == PAINT))
    {
        word++;
    }
    const uint32_t stack = (uint32_t)(stack_base - word) * 4U;
    stack_worst = (stack > stack_worst) ? stack : stack_worst;
    worst = (instructions > worst) ? instructions : worst;
    total += instructions;
    steps++;
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
    systick[1] = 0x00FFFFFFU;
    systick[2] = 0U;
    systick[0] = 5U;
    selftest_begin();
    selftest_end();
    overhead = worst;
    worst = 0U;
    stack_worst = 0U;
    total = 0U;
    steps = 0U;
    const selftest_result_t result = selftest_run();
    show("sequences", result.sequences);
    show("steps", result.steps);
    show("differences", result.differences);
    show("first_difference", result.first_difference);
    show("instructions_worst", worst);
    show("instructions_mean", (steps > 0U) ? (uint32_t)(total / steps) : 0U);
    show("stack_measured", stack_worst);
    return (result.differences == 0U) ? 0 : 1;
}

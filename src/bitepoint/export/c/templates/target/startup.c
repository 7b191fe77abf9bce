/* Start of a bare-metal image on a Cortex-M: vectors, memory, floating-point unit, then main. */
#include "semihosting.h"

#include <stdint.h>

extern uint32_t image_data_load, image_data_start, image_data_end, image_bss_start, image_bss_end, image_stack_top;

int main(void);
void reset_handler(void);
static void fault_handler(void);

static void fault_handler(void)
{
    semihosting_text("fault\n");
    semihosting_exit(3);
}

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[16] = {
    (uintptr_t)&image_stack_top,   (uintptr_t)&reset_handler, (uintptr_t)&fault_handler, (uintptr_t)&fault_handler,
    (uintptr_t)&fault_handler,     (uintptr_t)&fault_handler, (uintptr_t)&fault_handler, 0U, 0U, 0U, 0U,
    (uintptr_t)&fault_handler,     (uintptr_t)&fault_handler, 0U,                        (uintptr_t)&fault_handler,
    (uintptr_t)&fault_handler,
};

void reset_handler(void)
{
    volatile uint32_t *const coprocessors = (volatile uint32_t *)0xE000ED88U;
    *coprocessors |= 0x00F00000U; /* full access to the floating-point unit */
    __asm volatile("dsb\n\tisb" ::: "memory");
    const uint32_t *from = &image_data_load;
    for (uint32_t *to = &image_data_start; to < &image_data_end; to++)
    {
        *to = *from;
        from++;
    }
    for (uint32_t *to = &image_bss_start; to < &image_bss_end; to++)
    {
        *to = 0U;
    }
    semihosting_exit(main());
}

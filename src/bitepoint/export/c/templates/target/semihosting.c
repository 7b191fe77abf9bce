/* See semihosting.h; Arm's "Semihosting for AArch32 and AArch64", operations SYS_WRITE0 and SYS_EXIT_EXTENDED. */
#include "semihosting.h"

static void call(uintptr_t operation, const void *argument)
{
    register uintptr_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

void semihosting_text(const char *text)
{
    call(0x04U, text);
}

void semihosting_number(uint32_t number)
{
    char text[11];
    int place = 10;
    text[place] = '\0';
    do
    {
        place--;
        text[place] = (char)('0' + (int)(number % 10U));
        number /= 10U;
    } while (number > 0U);
    semihosting_text(&text[place]);
}

void semihosting_exit(int status)
{
    const uint32_t block[2] = {0x20026U, (uint32_t)status};
    call(0x20U, block);
    for (;;)
    {
        /* the emulator has gone */
    }
}

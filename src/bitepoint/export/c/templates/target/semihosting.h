/* Text and an exit status from a bare-metal image to the emulator or debugger that runs it. */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#include <stdint.h>

void semihosting_text(const char *text);
void semihosting_number(uint32_t number);
void semihosting_exit(int status);

#endif

/* Output, and the count of instructions, on QEMU's Cortex-M boards. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#define SYSTICK_MOST 0xffffffu

void print_text(const char *text);
/* Rises by one each 40 ns: with `-icount shift=0`, each 40 instructions. Begins again after 2^24.
 */
uint32_t ticks(void);
int main(void);

#endif

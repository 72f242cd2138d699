/* The least that a program needs on QEMU's Cortex-M boards: vectors, the floating-point unit,
   SysTick, and semihosting for output and the end. No C library. */
#include "board.h"

#include <stddef.h>

extern uint32_t stack_top;
void reset_handler(void);
static void fault_handler(void);

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void)) & stack_top,
    reset_handler,
    fault_handler,
    fault_handler,
    fault_handler,
    fault_handler,
    fault_handler};

#define CPACR (*(volatile uint32_t *)0xe000ed88u) /* access to the floating-point unit */
#define SYSTICK_CONTROL (*(volatile uint32_t *)0xe000e010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xe000e014u)
#define SYSTICK_VALUE (*(volatile uint32_t *)0xe000e018u)

/* Calls the debugger, here QEMU. */
static void semihost(uint32_t operation, const void *argument) {
  register uint32_t r0 __asm__("r0") = operation;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void print_text(const char *text) { semihost(0x04, text); }

static void end(uint32_t status) {
  const uint32_t block[2] = {0x20026u, status}; /* the application has ended */
  semihost(0x20, block);
  for (;;) {
  }
}

static void fault_handler(void) {
  print_text("fault\n");
  end(1);
}

void reset_handler(void) {
  CPACR |= 0xfu << 20;
  __asm__ volatile("dsb; isb");
  SYSTICK_RELOAD = SYSTICK_MOST;
  SYSTICK_VALUE = 0;
  SYSTICK_CONTROL = 5; /* counts the processor's clock, without interrupts */
  end((uint32_t)main());
}

uint32_t ticks(void) { return SYSTICK_MOST - SYSTICK_VALUE; }

/* The compiler calls these for copies of structures and arrays. */
void *memcpy(void *to, const void *from, size_t count) {
  size_t i;
  for (i = 0; i < count; ++i) ((volatile unsigned char *)to)[i] = ((const unsigned char *)from)[i];
  return to;
}

void *memset(void *to, int value, size_t count) {
  size_t i;
  for (i = 0; i < count; ++i) ((volatile unsigned char *)to)[i] = (unsigned char)value;
  return to;
}

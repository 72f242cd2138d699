/* Included after a policy's source: prints the hash of its self-test over STEPS steps. On a bare
   board also the ticks of CALLS calls. POLICY: its name. */
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define CALLS 10

#ifdef BARE
#include "board.h"
#else
#include <stdio.h>
static void print_text(const char *text) { fputs(text, stdout); }
#endif

static void print_number(uint32_t value) {
  char text[10];
  int i;
  for (i = 0; i < 8; ++i) text[i] = "0123456789abcdef"[(value >> (28 - 4 * i)) & 15u];
  text[8] = '\n';
  text[9] = '\0';
  print_text(text);
}

#ifdef BARE
static uint32_t ticks_of(int calls) {
  static JOIN(POLICY, _output) output;
  const uint32_t begin = ticks();
  int i;
  for (i = 0; i < calls; ++i) JOIN(POLICY, _step)(&state, &input, &output);
  return (ticks() - begin) & SYSTICK_MOST;
}
#endif

int main(void) {
  print_number(JOIN(POLICY, _self_test)(STEPS));
#ifdef BARE
  begin();
  print_number(ticks_of(CALLS));
#endif
  return 0;
}

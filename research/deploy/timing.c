/* Included after a policy's source: prints the least time of a call [ns] over ROUNDS rounds of
   CALLS calls. POLICY: its name. */
#include <stdio.h>
#include <time.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

int main(void) {
  static JOIN(POLICY, _output) output;
  double least = 1e18;
  int round, i;
  begin();
  for (round = 0; round < ROUNDS; ++round) {
    const double start = now();
    double call;
    for (i = 0; i < CALLS; ++i) JOIN(POLICY, _step)(&state, &input, &output);
    call = (now() - start) / CALLS;
    if (call < least) least = call;
  }
  printf("%.1f\n", least);
  return 0;
}

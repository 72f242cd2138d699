/* Functions that LAPACK and BLAS call, of Fortran's library (lapack.cmake). Fortran's texts have a
 * length and no end mark; shorter ones are filled with spaces. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Called for an argument that a routine does not allow, a mistake of its caller. */
void xerbla_(const char* routine, const int* argument, size_t length) {
  fprintf(stderr, " ** On entry to %.*s parameter number %2d had an illegal value\n", (int)length,
          routine, *argument);
  abort();
}

void _gfortran_concat_string(size_t length, char* to, size_t first_length, const char* first,
                             size_t second_length, const char* second) {
  memset(to, ' ', length);
  const size_t taken = first_length < length ? first_length : length;
  memcpy(to, first, taken);
  memcpy(to + taken, second, second_length < length - taken ? second_length : length - taken);
}

/* The length without the spaces at the end. */
size_t _gfortran_string_len_trim(size_t length, const char* text) {
  while (length > 0 && text[length - 1] == ' ') --length;
  return length;
}

/* Names that static HDF5 needs around it in the wheel's library (library.cmake). */
#include <stddef.h>
#include <stdio.h>

FILE* hdf5_stderr;
FILE* hdf5_stdout;

__attribute__((constructor)) static void set_streams(void) {
  hdf5_stderr = stderr;
  hdf5_stdout = stdout;
}

/* Functions of libcurl and OpenSSL for files on web servers: each fails, so that HDF5 reports that
 * it cannot open such a file. Only HDF5 sees these names. */
#define CURL_FAILS 2 /* CURLE_FAILED_INIT */

int curl_global_init(long flags) { return (void)flags, CURL_FAILS; }
void curl_global_cleanup(void) {}
void* curl_easy_init(void) { return NULL; }
void curl_easy_cleanup(void* handle) { (void)handle; }
int curl_easy_perform(void* handle) { return (void)handle, CURL_FAILS; }
int curl_easy_setopt(void* handle, int option, ...) {
  return (void)handle, (void)option, CURL_FAILS;
}
void* curl_slist_append(void* list, const char* text) { return (void)list, (void)text, NULL; }
void curl_slist_free_all(void* list) { (void)list; }
const void* EVP_sha256(void) { return NULL; }
void* HMAC(void) { return NULL; }
void* SHA256(void) { return NULL; }

/// Compiled into the executables of sanitizer builds only. OpenImageIO keeps its last error in a string that libpng's longjmp
/// jumps over: 31 bytes a damaged PNG, inside the library, not ours to free.
extern "C" const char *__lsan_default_suppressions(); // NOLINT: the name is the sanitizer's
extern "C" const char *__lsan_default_suppressions() { return "leak:libOpenImageIO\n"; }
/// Standard error belongs to the command: no table of what was suppressed.
extern "C" const char *__lsan_default_options(); // NOLINT
extern "C" const char *__lsan_default_options() { return "print_suppressions=0"; }
/// __tls_get_addr is not intercepted: GCC 12's runtime takes the storage of a thread that by chance begins 16 bytes into a page for what
/// glibc 2.19 allocated, reads its size from other bytes, and dies where it looks there for leaks (google/sanitizers, issue 1322). It is
/// looked through all the same, as memory that the dynamic linker allocated.
extern "C" const char *__asan_default_options(); // NOLINT
extern "C" const char *__asan_default_options() { return "intercept_tls_get_addr=0"; }

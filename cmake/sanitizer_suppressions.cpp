/// Compiled into the executables of sanitizer builds only. OpenImageIO keeps its last error in a string that libpng's longjmp
/// jumps over: 31 bytes a damaged PNG, inside the library, not ours to free.
extern "C" const char *__lsan_default_suppressions(); // NOLINT: the name is the sanitizer's
extern "C" const char *__lsan_default_suppressions() { return "leak:libOpenImageIO\n"; }
/// Standard error belongs to the command: no table of what was suppressed.
extern "C" const char *__lsan_default_options(); // NOLINT
extern "C" const char *__lsan_default_options() { return "print_suppressions=0"; }

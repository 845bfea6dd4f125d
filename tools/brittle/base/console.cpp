#include "tools/brittle/base/console.h"

#include <cstdarg>
#include <cstdio>

namespace brittle::tools {

namespace {

bool quiet = false;
bool data_on_standard_output = false;

} // namespace

void set_quiet(bool value) {
    quiet = value;
}

bool is_quiet() {
    return quiet;
}

void keep_standard_output_for_data() {
    data_on_standard_output = true;
}

void tell(const char* pattern, ...) {
    if (quiet) return;
    std::fputs("brittle: ", stderr);
    va_list arguments;
    va_start(arguments, pattern);
    std::vfprintf(stderr, pattern, arguments);
    va_end(arguments);
    std::fputc('\n', stderr);
}

void print_report(const char* pattern, ...) {
    if (quiet) return;
    va_list arguments;
    va_start(arguments, pattern);
    std::vfprintf(data_on_standard_output ? stderr : stdout, pattern, arguments);
    va_end(arguments);
}

} // namespace brittle::tools

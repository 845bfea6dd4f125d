// What the program tells: reports on standard output, notes on standard error. Errors are no matter of this file: main()
// writes them, whatever is set here.
//
//     add_flag_callback("--quiet", [] { set_quiet(true); });
//     tell("%s: %s", input.name.c_str(), text.c_str()); // brittle: bunny: two parts overlap
//     print_report("%zu pieces\n", pieces);
#pragma once

namespace brittle::tools {

// Neither reports nor notes nor progress. Before threads start.
void set_quiet(bool quiet);
[[nodiscard]] bool is_quiet();

// Standard output holds data, a mesh or JSON: reports go to standard error.
void keep_standard_output_for_data();

// Writes "brittle: ", the text and a line feed to standard error.
[[gnu::format(printf, 1, 2)]] void tell(const char* pattern, ...);
// Writes the text.
[[gnu::format(printf, 1, 2)]] void print_report(const char* pattern, ...);

} // namespace brittle::tools

// Elementary functions with equal bits on every machine: the C libraries round the last bit as they like.
//
// Each result is the double next to the exact value, but for one argument in about 2^40, where it may be the second
// next; on all machines it is the same one. They take about as long as ten calls of the C library: use them where
// positions are made, not in loops over triangles.
#pragma once

namespace brittle::fracture::rounded {

[[nodiscard]] double sin(double x); // |x| at most 2^20
[[nodiscard]] double cos(double x);
[[nodiscard]] double acos(double x);            // x from -1 to 1
[[nodiscard]] double log(double x);             // x finite and above 0
[[nodiscard]] double cbrt(double x);            // x finite
[[nodiscard]] double hypot(double x, double y); // squares and their sum finite and normal, or zero
[[nodiscard]] double pow(double x, double y);   // x finite and not below 0; the result finite

} // namespace brittle::fracture::rounded

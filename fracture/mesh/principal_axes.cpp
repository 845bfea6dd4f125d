#include "fracture/mesh/principal_axes.h"

#include <algorithm>
#include <cmath>

namespace brittle::fracture {

namespace {

// Applies the Jacobi rotation that zeroes tensor[p][q]; `axes` accumulates the rotations. With p and q as constants
// everything stays in registers.
template<int p, int q>
void rotate_away(glm::dmat3& tensor, glm::dmat3& axes) {
    const double off = tensor[q][p];
    if (off == 0.0) return;
    const double theta = (tensor[q][q] - tensor[p][p]) / (2.0 * off);
    // The smaller of the two rotation angles preserves the order of the axes. 1/(2 theta) avoids the overflow of
    // theta^2.
    const double tangent = std::abs(theta) > 1e150
                               ? 0.5 / theta
                               : std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
    const double cosine = 1.0 / std::sqrt(tangent * tangent + 1.0);
    const double sine = tangent * cosine;
    glm::dmat3 rotation(1.0);
    rotation[p][p] = rotation[q][q] = cosine;
    rotation[q][p] = sine;
    rotation[p][q] = -sine;
    tensor = glm::transpose(rotation) * tensor * rotation;
    tensor[p][q] = tensor[q][p] = 0.0;
    axes = axes * rotation;
}

} // namespace

PrincipalAxes principal_axes(const glm::dmat3& tensor) {
    glm::dmat3 work = tensor;
    work[0][1] = work[1][0];
    work[0][2] = work[2][0];
    work[1][2] = work[2][1];
    // Scaled, so that the squares of a tiny piece's moments (1e-20 kg m^2) neither underflow nor decide the
    // convergence.
    double scale = 0.0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) scale = std::max(scale, std::abs(work[column][row]));
    if (scale == 0.0) return {};
    work /= scale;

    glm::dmat3 axes(1.0);
    // Convergence is quadratic: five sweeps reach rounding precision for any 3x3 tensor; twelve are a safe bound.
    for (int sweep = 0; sweep < 12; ++sweep) {
        const double off = std::abs(work[1][0]) + std::abs(work[2][0]) + std::abs(work[2][1]);
        if (off < 1e-15) break;
        rotate_away<0, 1>(work, axes);
        rotate_away<0, 2>(work, axes);
        rotate_away<1, 2>(work, axes);
    }
    return {axes, glm::dvec3(work[0][0], work[1][1], work[2][2]) * scale};
}

} // namespace brittle::fracture

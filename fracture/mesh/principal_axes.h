// Principal axes of an inertia tensor.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace brittle::fracture {

struct PrincipalAxes {
    glm::dmat3 axes{1.0};    // columns: right-handed orthonormal principal axes
    glm::dvec3 moments{0.0}; // about them: tensor = axes * diag(moments) * transpose(axes)
};

// Eigenvectors and eigenvalues of a symmetric tensor (cyclic Jacobi; the upper triangle is read). A diagonal
// tensor gives the coordinate axes in their order. Any finite input has a result.
[[nodiscard]] PrincipalAxes principal_axes(const glm::dmat3& tensor);

} // namespace brittle::fracture

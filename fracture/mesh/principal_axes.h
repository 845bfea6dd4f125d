// Principal axes and moments of an inertia tensor.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace brittle::fracture {

struct PrincipalAxes {
    glm::dmat3 axes{1.0};    // columns: the principal axes, orthonormal and right-handed
    glm::dvec3 moments{0.0}; // about those axes: tensor = axes * diag(moments) * transpose(axes)
};

// Returns the eigenvectors and eigenvalues of a symmetric tensor (cyclic Jacobi; reads the upper triangle). A diagonal
// tensor gives the coordinate axes in their order. Every finite input has a result.
[[nodiscard]] PrincipalAxes principal_axes(const glm::dmat3& tensor);

} // namespace brittle::fracture

#include "fracture/exact/predicates.h"

#include <algorithm>
#include <cassert>

#include "fracture/arithmetic/expansion.h"

namespace brittle::fracture::exact {
namespace {

// --- Exact vectors and plane rows, in the frame of site c

struct ExactVector {
    Expansion x, y, z;
};

ExactVector difference(const glm::dvec3& p, const glm::dvec3& q) {
    return {Expansion::difference(p.x, q.x), Expansion::difference(p.y, q.y), Expansion::difference(p.z, q.z)};
}

Expansion dot(const ExactVector& a, const ExactVector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

ExactVector cross(const ExactVector& a, const ExactVector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// The plane k - n.y of a frame, scaled by a positive number such that a perturbation by weights adds to k alone.
struct Row {
    ExactVector n;
    Expansion k;
};

Row site_row(const Diagram& diagram, SiteId c, SiteId l) {
    ExactVector n = difference(diagram.sites[l], diagram.sites[c]);
    Expansion k = dot(n, n);
    if (!diagram.weights.empty()) k = k + Expansion::difference(diagram.weights[c], diagram.weights[l]);
    return {{n.x.scaled(2.0), n.y.scaled(2.0), n.z.scaled(2.0)}, k};
}

Row box_row(const glm::dvec3& s_c, const Box& box, PlaneId p) {
    const int axis = static_cast<int>((p - box_min_x) / 2);
    const bool max = ((p - box_min_x) & 1u) != 0;
    Row row;
    Expansion& n = axis == 0 ? row.n.x : (axis == 1 ? row.n.y : row.n.z);
    n = Expansion(max ? 1.0 : -1.0);
    row.k = max ? Expansion::difference(box.max[axis], s_c[axis]) : Expansion::difference(s_c[axis], box.min[axis]);
    return row;
}

Row plane_row(const Diagram& diagram, SiteId c, PlaneId p) {
    return is_box_plane(p) ? box_row(diagram.sites[c], diagram.box, p) : site_row(diagram, c, p);
}

// Positive behind the triangle, inside the solid.
Row triangle_row(const glm::dvec3& s_c, const Corners& q) {
    ExactVector n = cross(difference(q[1], q[0]), difference(q[2], q[0]));
    Expansion k = dot(n, difference(q[0], s_c));
    return {n, k};
}

// g_l(q) = (s_l - s_c).(s_l + s_c - 2q) + W_c - W_l, with the second factor as (s_l - q) + (s_c - q).
Expansion exact_value(const Diagram& diagram, SiteId c, SiteId l, const glm::dvec3& q) {
    const glm::dvec3 &s_c = diagram.sites[c], &s_l = diagram.sites[l];
    Expansion g;
    if (!diagram.weights.empty()) g = Expansion::difference(diagram.weights[c], diagram.weights[l]);
    for (int i = 0; i < 3; ++i) {
        g = g
            + Expansion::difference(s_l[i], s_c[i])
                  * (Expansion::difference(s_l[i], q[i]) + Expansion::difference(s_c[i], q[i]));
    }
    return g;
}

ExactVector exact_values(const Diagram& diagram, SiteId c, SiteId l, const Corners& q) {
    return {exact_value(diagram, c, l, q[0]), exact_value(diagram, c, l, q[1]), exact_value(diagram, c, l, q[2])};
}

Expansion component_sum(const ExactVector& v) {
    return v.x + v.y + v.z;
}

// --- Symbolic perturbation

// A term of the perturbed numerator: kappa * (w_c - w_site).
struct WeightTerm {
    SiteId site;
    Expansion kappa;
};

// The sign of the sum of kappa_x (w_c - w_x) for w_0 >> w_1 >> ...: that of the first nonzero coefficient in index
// order.
template<int N>
int perturbation_sign(SiteId c, const std::array<WeightTerm, N>& terms) {
    std::array<const WeightTerm*, N> order;
    for (int i = 0; i < N; ++i) order[i] = &terms[i];
    std::sort(order.begin(), order.end(), [](const auto* p, const auto* q) { return p->site < q->site; });
    bool c_done = false;
    for (const WeightTerm* term : order) {
        if (!c_done && c < term->site) {
            c_done = true;
            Expansion of_c;
            for (const WeightTerm& t : terms) of_c = of_c + t.kappa;
            if (of_c.sign() != 0) return of_c.sign();
        }
        if (term->kappa.sign() != 0) return -term->kappa.sign();
    }
    // All other coefficients vanish, and so does that of w_c, their negated sum.
    return 0;
}

// --- The 4 x 4 determinant of side4 and pierce_order

// Plane l against the point of planes a, b, d: the numerator, the denominator [abd], and the factor of each row's k in
// the numerator.
struct PlaneDeterminant {
    Expansion numerator;
    Expansion kappa_a, kappa_b, kappa_d, kappa_l; // kappa_l = [abd], the denominator
};

PlaneDeterminant plane_determinant(const Row& a, const Row& b, const Row& d, const Row& l) {
    // [xyz] = x.(y x z). Two cross products serve all four determinants.
    const ExactVector ab = cross(a.n, b.n);
    const ExactVector dl = cross(d.n, l.n);
    PlaneDeterminant determinant;
    determinant.kappa_l = dot(ab, d.n);
    determinant.kappa_d = -dot(ab, l.n);
    determinant.kappa_b = dot(a.n, dl);
    determinant.kappa_a = -dot(b.n, dl);
    determinant.numerator =
        l.k * determinant.kappa_l + d.k * determinant.kappa_d + b.k * determinant.kappa_b + a.k * determinant.kappa_a;
    return determinant;
}

} // namespace

PredicateStats& PredicateStats::operator+=(const PredicateStats& other) {
    side1_exact += other.side1_exact;
    side2_exact += other.side2_exact;
    side3_exact += other.side3_exact;
    side4_exact += other.side4_exact;
    pierce_exact += other.pierce_exact;
    orientation_exact += other.orientation_exact;
    perturbed += other.perturbed;
    return *this;
}

// --- Filters

PiercePosition pierce_position(const Bisector& a, const Bisector& b, const Corners& y, const glm::dvec3& a_values,
                               const glm::dvec3& b_values, double error) {
    constexpr double u = 0x1.0p-53;
    const glm::dvec3 d = glm::cross(a.n, b.n);
    const double t0 = glm::dot(y[0], d);
    const double t1 = glm::dot(y[1], d);
    const double t2 = glm::dot(y[2], d);
    const double reach = 1.7321 * std::max({largest_component(y[0]), largest_component(y[1]), largest_component(y[2])});
    // y.d: 1u for y, 4u for d (sqrt(2) for its two products), 3u for the dot: 8 sqrt(2) u.
    const double t_error = 12.0 * u * a.length * b.length * reach;

    // t = t0 + (c1 (t1 - t0) + c2 (t2 - t0)) / (c0 + c1 + c2), with the cofactors c of A and B. In this form their
    // errors are multiplied by the size of the triangle only.
    const double c0 = a_values.y * b_values.z - a_values.z * b_values.y;
    const double c1 = a_values.z * b_values.x - a_values.x * b_values.z;
    const double c2 = a_values.x * b_values.y - a_values.y * b_values.x;
    const double denominator = c0 + c1 + c2;
    const double offset = (c1 * (t1 - t0) + c2 * (t2 - t0)) / denominator;

    const double ma = largest_component(a_values);
    const double mb = largest_component(b_values);
    const double span = std::max(std::abs(t1 - t0), std::abs(t2 - t0));
    const double c_error = 2.01 * error * (ma + mb + error) + 4.0 * u * ma * mb;
    const double denominator_error = 3.0 * c_error + 18.0 * u * ma * mb;
    const double c_largest = std::max(std::abs(c1), std::abs(c2));
    const double numerator_error = 2.0 * (c_error * span + (c_largest + c_error) * (2.0 * t_error + 4.0 * u * span));
    const double margin = std::abs(denominator) - denominator_error;
    if (!(margin > 0.0)) return {t0 + offset, std::numeric_limits<double>::infinity()};
    const double offset_error = (numerator_error + std::abs(offset) * denominator_error) / margin;
    const double t = t0 + offset;
    return {t, 1.01 * (t_error + offset_error + 4.0 * u * (std::abs(offset) + std::abs(t)))};
}

// --- Exact signs

int side1_exact(const Diagram& diagram, SiteId c, SiteId l, const glm::dvec3& q, PredicateStats& stats) {
    ++stats.side1_exact;
    const int sign = exact_value(diagram, c, l, q).sign();
    if (sign != 0) return sign;
    ++stats.perturbed;
    return c < l ? 1 : -1;
}

int side2_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId l, const glm::dvec3& q0, const glm::dvec3& q1,
                PredicateStats& stats) {
    ++stats.side2_exact;
    const Expansion a0 = exact_value(diagram, c, a, q0);
    const Expansion a1 = exact_value(diagram, c, a, q1);
    const Expansion l0 = exact_value(diagram, c, l, q0);
    const Expansion l1 = exact_value(diagram, c, l, q1);
    const Expansion denominator = a0 - a1;
    assert(denominator.sign() != 0);
    int sign = (a0 * l1 - a1 * l0).sign();
    if (sign == 0) {
        ++stats.perturbed;
        sign = perturbation_sign<2>(c, {{{a, l1 - l0}, {l, denominator}}});
    }
    return sign * denominator.sign();
}

int side3_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, SiteId l, const Corners& q,
                PredicateStats& stats) {
    ++stats.side3_exact;
    const ExactVector va = exact_values(diagram, c, a, q);
    const ExactVector vb = exact_values(diagram, c, b, q);
    const ExactVector vl = exact_values(diagram, c, l, q);
    const ExactVector ab = cross(va, vb);
    const Expansion denominator = component_sum(ab);
    assert(denominator.sign() != 0);
    int sign = dot(ab, vl).sign();
    if (sign == 0) {
        ++stats.perturbed;
        // det[1;B;L] and det[A;1;L] = det[1;L;A].
        sign = perturbation_sign<3>(
            c, {{{a, component_sum(cross(vb, vl))}, {b, component_sum(cross(vl, va))}, {l, denominator}}});
    }
    return sign * denominator.sign();
}

int side4_exact(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d, SiteId l, PredicateStats& stats) {
    ++stats.side4_exact;
    const PlaneDeterminant determinant = plane_determinant(plane_row(diagram, c, a), plane_row(diagram, c, b),
                                                           plane_row(diagram, c, d), plane_row(diagram, c, l));
    assert(determinant.kappa_l.sign() != 0);
    int sign = determinant.numerator.sign();
    if (sign == 0) {
        ++stats.perturbed;
        const auto weight = [](PlaneId p, const Expansion& kappa) {
            return WeightTerm{p, is_box_plane(p) ? Expansion() : kappa};
        };
        sign = perturbation_sign<4>(c, {{weight(a, determinant.kappa_a), weight(b, determinant.kappa_b),
                                         weight(d, determinant.kappa_d), weight(l, determinant.kappa_l)}});
    }
    return sign * determinant.kappa_l.sign();
}

int pierce_order_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q1, const Corners& q2,
                       PredicateStats& stats) {
    ++stats.pierce_exact;
    const glm::dvec3& s_c = diagram.sites[c];
    const Row row_a = site_row(diagram, c, a);
    const Row row_b = site_row(diagram, c, b);
    const PlaneDeterminant determinant = plane_determinant(row_a, row_b, triangle_row(s_c, q1), triangle_row(s_c, q2));
    // kappa_l = [a b T1]; kappa_d = -[a b T2].
    assert(determinant.kappa_l.sign() != 0 && determinant.kappa_d.sign() != 0);
    int sign = determinant.numerator.sign();
    if (sign == 0) {
        ++stats.perturbed;
        sign = perturbation_sign<2>(c, {{{a, determinant.kappa_a}, {b, determinant.kappa_b}}});
    }
    // The value of T2 at pierce 1 is (t2 - t1)[abT2] up to a positive factor.
    return sign * determinant.kappa_l.sign() * determinant.kappa_d.sign();
}

int pierce_direction_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q,
                           PredicateStats& stats) {
    ++stats.pierce_exact;
    const glm::dvec3& s_c = diagram.sites[c];
    const ExactVector d = cross(difference(diagram.sites[a], s_c), difference(diagram.sites[b], s_c));
    return dot(d, cross(difference(q[1], q[0]), difference(q[2], q[0]))).sign();
}

int cell_vertex_orientation_exact(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d,
                                  PredicateStats& stats) {
    ++stats.orientation_exact;
    const Row row_a = plane_row(diagram, c, a);
    return dot(row_a.n, cross(plane_row(diagram, c, b).n, plane_row(diagram, c, d).n)).sign();
}

// --- Filter and exact function in one call

int side1(const Diagram& diagram, SiteId c, SiteId l, const glm::dvec3& q, PredicateStats& stats) {
    const Bisector plane = make_bisector(diagram, c, l);
    const glm::dvec3 y = q - diagram.sites[c];
    const int sign = side1_filter(value(plane, y), value_error(plane.length, glm::length(y), plane.weight));
    return sign != 0 ? sign : side1_exact(diagram, c, l, q, stats);
}

int side2(const Diagram& diagram, SiteId c, SiteId a, SiteId l, const glm::dvec3& q0, const glm::dvec3& q1,
          PredicateStats& stats) {
    const glm::dvec3& s_c = diagram.sites[c];
    const Bisector pa = make_bisector(diagram, c, a);
    const Bisector pl = make_bisector(diagram, c, l);
    const glm::dvec3 y0 = q0 - s_c;
    const glm::dvec3 y1 = q1 - s_c;
    const double error = value_error(std::max(pa.length, pl.length), std::max(glm::length(y0), glm::length(y1)),
                                     std::max(pa.weight, pl.weight));
    const int sign = side2_filter(value(pa, y0), value(pa, y1), value(pl, y0), value(pl, y1), error);
    return sign != 0 ? sign : side2_exact(diagram, c, a, l, q0, q1, stats);
}

namespace {

// The corners of a triangle in the frame of c, and the largest distance of a corner from it.
struct CornerFrame {
    Corners y;
    double reach;
};

CornerFrame corner_frame(const glm::dvec3& s_c, const Corners& q) {
    const Corners y{q[0] - s_c, q[1] - s_c, q[2] - s_c};
    return {y, std::max({glm::length(y[0]), glm::length(y[1]), glm::length(y[2])})};
}

glm::dvec3 values(const Bisector& plane, const Corners& y) {
    return {value(plane, y[0]), value(plane, y[1]), value(plane, y[2])};
}

} // namespace

int side3(const Diagram& diagram, SiteId c, SiteId a, SiteId b, SiteId l, const Corners& q, PredicateStats& stats) {
    const glm::dvec3& s_c = diagram.sites[c];
    const Bisector pa = make_bisector(diagram, c, a);
    const Bisector pb = make_bisector(diagram, c, b);
    const Bisector pl = make_bisector(diagram, c, l);
    const CornerFrame frame = corner_frame(s_c, q);
    const double error = value_error(std::max({pa.length, pb.length, pl.length}), frame.reach,
                                     std::max({pa.weight, pb.weight, pl.weight}));
    const int sign = side3_filter(values(pa, frame.y), values(pb, frame.y), values(pl, frame.y), error);
    return sign != 0 ? sign : side3_exact(diagram, c, a, b, l, q, stats);
}

int side4(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d, SiteId l, PredicateStats& stats) {
    const CellVertex v =
        make_cell_vertex(make_plane(diagram, c, a), make_plane(diagram, c, b), make_plane(diagram, c, d));
    const int sign = side4_filter(v, make_plane(diagram, c, l));
    return sign != 0 ? sign : side4_exact(diagram, c, a, b, d, l, stats);
}

int pierce_order(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q1, const Corners& q2,
                 PredicateStats& stats) {
    const glm::dvec3& s_c = diagram.sites[c];
    const Bisector pa = make_bisector(diagram, c, a);
    const Bisector pb = make_bisector(diagram, c, b);
    const auto position = [&](const Corners& q) {
        const CornerFrame frame = corner_frame(s_c, q);
        const double error = value_error(std::max(pa.length, pb.length), frame.reach, std::max(pa.weight, pb.weight));
        return pierce_position(pa, pb, frame.y, values(pa, frame.y), values(pb, frame.y), error);
    };
    const int sign = pierce_order_filter(position(q1), position(q2));
    return sign != 0 ? sign : pierce_order_exact(diagram, c, a, b, q1, q2, stats);
}

// --- Constructions

double edge_parameter_exact(const Diagram& diagram, SiteId c, SiteId a, const glm::dvec3& q0, const glm::dvec3& q1) {
    const Expansion a0 = exact_value(diagram, c, a, q0);
    const Expansion denominator = a0 - exact_value(diagram, c, a, q1);
    assert(denominator.sign() != 0);
    return std::clamp(a0.approximation() / denominator.approximation(), 0.0, 1.0);
}

glm::dvec3 pierce_weights_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q) {
    const ExactVector cofactors = cross(exact_values(diagram, c, a, q), exact_values(diagram, c, b, q));
    const Expansion denominator = component_sum(cofactors);
    assert(denominator.sign() != 0);
    const glm::dvec3 weights =
        glm::dvec3(cofactors.x.approximation(), cofactors.y.approximation(), cofactors.z.approximation())
        / denominator.approximation();
    return {std::clamp(weights.x, 0.0, 1.0), std::clamp(weights.y, 0.0, 1.0), std::clamp(weights.z, 0.0, 1.0)};
}

glm::dvec3 cell_vertex_exact(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d) {
    const Row ra = plane_row(diagram, c, a);
    const Row rb = plane_row(diagram, c, b);
    const Row rd = plane_row(diagram, c, d);
    const ExactVector bd = cross(rb.n, rd.n);
    const ExactVector da = cross(rd.n, ra.n);
    const ExactVector ab = cross(ra.n, rb.n);
    const Expansion w = dot(ra.n, bd);
    assert(w.sign() != 0);
    const glm::dvec3 x((ra.k * bd.x + rb.k * da.x + rd.k * ab.x).approximation(),
                       (ra.k * bd.y + rb.k * da.y + rd.k * ab.y).approximation(),
                       (ra.k * bd.z + rb.k * da.z + rd.k * ab.z).approximation());
    return x / w.approximation();
}

} // namespace brittle::fracture::exact

#include "tools/scenario/recipe/input.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/doctor/repair.h"
#include "fracture/io/import.h"
#include "fracture/io/text_cursor.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/material.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/base/stopwatch.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

constexpr std::string_view shape_prefix = "shape:";
constexpr std::string_view standard_input = "-";

fracture::Model load_model(const std::string& mesh, bool with_looks, const Host& host, const std::string& format) {
    fracture::Model model;
    if (mesh == standard_input && host.standard_input) {
        model = host.standard_input(format);
        if (!with_looks) keep_mesh_only(model);
        return model;
    }
    if (!mesh.starts_with(shape_prefix)) {
        if (with_looks) return must(fracture::import_model(mesh));
        model.mesh = must(fracture::import_mesh(mesh));
        return model;
    }
    const std::string_view name = std::string_view(mesh).substr(shape_prefix.size());
    if (std::optional<fracture::TriangleMesh> shape = fracture::shape(name)) {
        model.mesh = std::move(*shape);
        return model;
    }
    std::string known;
    for (const std::string_view s : fracture::shape_names()) known.append(known.empty() ? "" : ", ").append(s);
    throw Failure(exit_input, "there is no shape named '" + std::string(name) + "'; the shapes are: " + known);
}

// Tells the host what was done to a mesh; `none` where that is nothing.
void report(const Host& host, const std::string& name, const char* none, const char* done, std::string lines) {
    if (!host.report) return;
    if (lines.ends_with('\n')) lines.pop_back();
    host.report(name + ": " + (lines.empty() ? none : done + lines));
}

void repair(fracture::Model& model, const std::string& name, const Host& host) {
    fracture::Repaired repaired = fracture::repair(model.mesh);
    report(host, name, "nothing to repair", "repaired\n", fracture::describe(repaired.report));
    if (repaired.report.changed()) fracture::replace_mesh(model, std::move(repaired.mesh), repaired.source_triangle);
}

// Throws a failure that names --repair if repair would close the mesh. Called before fracture() refuses it.
void suggest_repair(const fracture::TriangleMesh& mesh, const std::string& name) {
    const auto report = fracture::check_topology(mesh.positions.size(), mesh.triangles);
    if (report.closed()) return;
    const fracture::Repaired repaired = fracture::repair(mesh);
    const auto after = fracture::check_topology(repaired.mesh.positions.size(), repaired.mesh.triangles);
    if (!after.closed() || repaired.mesh.triangles.empty()) return;
    throw Failure(exit_mesh, name + ": " + fracture::describe(report) + ". Add --repair to repair the mesh first:\n"
                                 + fracture::describe(repaired.report) + "The mesh is then closed");
}

constexpr std::array<std::pair<const char*, double>, 5> length_units = {
    {{"fit", 1.0}, {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"inch", 0.0254}}};

} // namespace

const char* to_string(LengthUnit unit) {
    return length_units[static_cast<size_t>(unit)].first;
}

std::optional<LengthUnit> length_unit(const std::string& name) {
    for (size_t unit = 0; unit < length_units.size(); ++unit)
        if (name == length_units[unit].first) return static_cast<LengthUnit>(unit);
    return std::nullopt;
}

double metres_of(LengthUnit unit) {
    return length_units[static_cast<size_t>(unit)].second;
}

std::string mesh_name(const std::string& mesh) {
    if (mesh.starts_with(shape_prefix)) return mesh.substr(shape_prefix.size());
    return mesh == standard_input ? "mesh" : std::filesystem::path(mesh).stem().string();
}

Input load_mesh_only(const std::string& mesh, bool with_looks, const Host& host, const std::string& format) {
    Input input;
    input.name = mesh_name(mesh);
    const Stopwatch import;
    input.model = load_model(mesh, with_looks, host, format);
    input.import_milliseconds = import.milliseconds();
    return input;
}

FractureOptions scene_of_pieces(FractureOptions options) {
    if (options.pieces_from.empty()) return options;
    if (is_scene(options))
        throw Failure(exit_usage, "--pieces-from takes no scene beside it; add an object with "
                                  "\"in_pieces\": true to the scene instead");
    if (options.repair || options.unite || !options.strikes.empty() || !options.points.empty()
        || !options.sites_file.empty())
        throw Failure(exit_usage,
                      "--pieces-from takes pieces as they are; leave --repair, --unite, --strike and --sites "
                      "out");
    FractureOptions scene;
    SceneObject& object = scene.objects.emplace_back();
    object.recipe = options;
    object.recipe.mesh = options.pieces_from;
    object.recipe.pieces_from.clear();
    object.recipe.save_recipe.clear();
    object.name = options.exports.name.empty() ? mesh_name(options.pieces_from) : options.exports.name;
    object.in_pieces = true;
    WorldOptions& own = object.recipe.world;
    own.bonded = own.breakable = true;
    own.height = 0.0;
    object.recipe.exports = {};
    own.shots.clear();
    own.joints.clear();
    scene.world = options.world;
    scene.world.anchored = scene.world.bonded = scene.world.breakable = false;
    scene.world.anchors.clear();
    scene.units = options.units == LengthUnit::fit ? LengthUnit::metre : options.units;
    scene.picture = options.picture;
    scene.exports = options.exports;
    scene.exports.name.clear(); // the object has it
    scene.threads = options.threads;
    scene.save_recipe = options.save_recipe;
    return scene;
}

namespace {

// Moves sites; weights, which are squared radii, scale with the square of distances.
void place_sites(SiteSet& set, const fracture::Box& from, const fracture::Box& onto, const fracture::Placement& p) {
    const glm::dvec3 ends[] = {glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 0.0)};
    const auto moved = fracture::place(ends, from, onto, p);
    const glm::dvec3 unit = moved[1] - moved[0];
    for (double& weight : set.weights) weight *= glm::dot(unit, unit);
    set.sites = fracture::place(set.sites, from, onto, p);
}

SiteSet sites_of_file(const FractureOptions& options, const fracture::TriangleMesh& mesh) {
    fracture::SiteList list = must(fracture::read_sites(options.sites_file));
    SiteSet set{std::move(list.sites), {}, std::move(list.weights)};
    const fracture::Box own = fracture::bounds(set.sites);
    const fracture::Box onto = options.fit_sites ? fracture::bounds(mesh) : own;
    const fracture::Placement& p = options.sites_placement;
    if (options.fit_sites || p.scale != 1.0 || p.turn != glm::dvec3(0.0) || p.move != glm::dvec3(0.0))
        place_sites(set, own, onto, p);
    return set;
}

} // namespace

fracture::Roughness roughness_of(const FractureOptions& options, double scale) {
    fracture::Roughness rough = options.rough;
    rough.wavelength *= scale;
    rough.seed = options.pattern.seed;
    return rough;
}

WorldOptions world_of(const FractureOptions& options, double scale) {
    WorldOptions world = options.world;
    world.seed = options.pattern.seed;
    world.rough = roughness_of(options, scale);
    // If the pattern has already cut the mesh, or the recipe lists sites, blows break by the material. Strikes override
    // sites.
    const bool given = options.strikes.empty();
    if (!starts_whole(world) || (given && !options.points.empty())) return world;
    world.blows = {.kind = options.pattern.kind, .slenderness = options.pattern.slenderness};
    if (given && !options.sites_file.empty()) {
        world.blows->diagram = must(fracture::read_sites(options.sites_file)).sites;
        world.blows->placement = options.sites_placement;
    }
    return world;
}

namespace {

// Leaves weights and groups empty if they have no effect: fracture.h allows more without them.
SiteSet site_set(std::span<const PlacedSite> points) {
    SiteSet set;
    std::map<uint32_t, uint32_t> first; // first site of each group
    bool weighted = false, grouped = false;
    for (uint32_t s = 0; s < points.size(); ++s) {
        const PlacedSite& point = points[s];
        set.sites.push_back(point.at);
        set.weights.push_back(point.weight);
        set.groups.push_back(point.group == 0 ? s : first.try_emplace(point.group, s).first->second);
        weighted |= point.weight != 0.0;
        grouped |= set.groups.back() != s;
    }
    if (!weighted) set.weights.clear();
    if (!grouped) set.groups.clear();
    return set;
}

} // namespace

std::vector<PlacedSite> placed_sites(const SiteSet& set) {
    std::map<uint32_t, uint32_t> sizes, numbers;
    for (const uint32_t group : set.groups) ++sizes[group];
    std::vector<PlacedSite> points;
    for (size_t s = 0; s < set.sites.size(); ++s) {
        PlacedSite point{set.sites[s], set.weights.empty() ? 0.0 : set.weights[s]};
        if (!set.groups.empty() && sizes[set.groups[s]] > 1)
            point.group = numbers.try_emplace(set.groups[s], static_cast<uint32_t>(numbers.size() + 1)).first->second;
        points.push_back(point);
    }
    return points;
}

SiteSet sites_for(const FractureOptions& options, const fracture::TriangleMesh& mesh) {
    if (options.strikes.empty() && !options.points.empty()) return site_set(options.points);
    if (options.strikes.empty() && !options.sites_file.empty()) return sites_of_file(options, mesh);
    const physics::MaterialPreset* preset = physics::material_preset(options.material);
    const fracture::Pattern pattern = options.automatic
                                          ? automatic_pattern(*options.automatic, options.pattern, mesh,
                                                              preset ? preset->material : physics::Material{})
                                          : options.pattern;
    fracture::PatternSites made =
        must(options.strikes.empty() ? fracture::make_sites(pattern, mesh) : strike_sites(options.strikes, pattern));
    return {std::move(made.sites), std::move(made.groups), std::move(made.weights)};
}

void use_material(const std::string& name, FractureOptions& options) {
    const physics::MaterialPreset* preset = physics::material_preset(name);
    if (!preset) {
        std::string known;
        for (const auto& p : physics::material_presets()) known.append(known.empty() ? "" : ", ").append(p.name);
        throw Failure(exit_usage, "there is no material " + fracture::quoted(std::string_view(name))
                                      + "; the materials are: " + known);
    }
    options.material = name;
    options.pattern.kind = preset->pattern.kind;
    options.pattern.jitter = preset->pattern.jitter;
    options.pattern.axis = preset->pattern.axis;
    options.pattern.spread = preset->pattern.spread;
    options.pattern.slenderness = preset->pattern.slenderness;
    options.rough.amount = preset->rough.amount;
    options.rough.grain = preset->rough.grain;
    options.rough.detail = preset->rough.detail;
}

glm::dvec3 grain_of_material(const FractureOptions& options, const glm::dvec3& axis) {
    const physics::MaterialPreset* preset = physics::material_preset(options.material);
    if (!preset) return glm::dvec3(0.0);
    const double stretch = glm::length(preset->rough.grain), length = glm::length(axis);
    return stretch > 0.0 && length > 0.0 ? stretch / length * axis : preset->rough.grain;
}

void keep_mesh_only(fracture::Model& model) {
    fracture::Model rest;
    rest.mesh = std::move(model.mesh);
    model = std::move(rest);
}

void prepare_mesh(const FractureOptions& options, Input& input, const Host& host) {
    if (options.repair) {
        repair(input.model, input.name, host);
    } else {
        suggest_repair(input.model.mesh, input.name);
    }
    if (!options.unite) return;
    report(host, input.name, "nothing to unite", "", fracture::describe(unite_parts(input.model, input.name)));
}

fracture::UniteReport unite_parts(fracture::Model& model, const std::string& name) {
    const auto topology = fracture::check_topology(model.mesh.positions.size(), model.mesh.triangles);
    if (!topology.closed())
        throw Failure(exit_mesh, name + ": parts can be united only where the mesh is closed, and it has "
                                     + fracture::describe(topology) + ". Repair it first");
    fracture::United united = fracture::unite(model.mesh);
    if (united.mesh.triangles.empty())
        throw Failure(exit_mesh,
                      name
                          + (united.report.inside_out > 0.0
                                 ? ": the whole surface is inside out, so the union is empty. Turn it first: "
                                   "`brittle repair` does"
                                 : ": the surface encloses no space, so the union is empty"));
    if (united.report.changed()) fracture::divide_mesh(model, std::move(united.mesh), united.source_triangle);
    return united.report;
}

std::string overlap_text(const fracture::UniteReport& report) {
    constexpr double rounding = 1e-6; // of the volume
    char text[160] = "";
    if (report.inside_out > rounding * report.volume_after)
        std::snprintf(text, sizeof text, "its surface is inside out around %.3g %% of its volume, so pieces lack that",
                      100.0 * report.inside_out / report.volume_after);
    else if (report.excess() > rounding)
        std::snprintf(text, sizeof text, "its parts pass through each other, so %.3g %% of its volume counts twice",
                      100.0 * report.excess());
    return text;
}

std::string overlap_of(const fracture::TriangleMesh& mesh) {
    if (!fracture::check_topology(mesh.positions.size(), mesh.triangles).closed()) return {};
    return overlap_text(fracture::measure_union(mesh));
}

void refuse_scene(const FractureOptions& options) {
    if (!is_scene(options)) return;
    const std::string what =
        options.level.mesh.empty() ? std::to_string(options.objects.size()) + " objects" : options.level.mesh;
    throw Failure(exit_usage, "the recipe is a scene of " + what
                                  + "; this command takes one mesh. `brittle fracture` breaks scenes");
}

Input load_input(const FractureOptions& options, bool with_looks, const Host& host) {
    refuse_scene(options);
    if (options.mesh.empty()) throw Failure(exit_usage, "no mesh: give a file, shape:NAME, or a recipe that names one");
    Input input = load_mesh_only(options.mesh, with_looks, host, options.format);
    input.units = options.units;
    if (!options.save_recipe.empty()) write_recipe(options.save_recipe, options);
    prepare_mesh(options, input, host);
    SiteSet set = sites_for(options, input.model.mesh);
    input.sites = std::move(set.sites);
    input.groups = std::move(set.groups);
    input.weights = std::move(set.weights);
    return input;
}

namespace {

// Fractures with a single cell: each connected part of the mesh becomes one piece.
fracture::Result<fracture::Fragments> uncut(const Input& input, fracture::Settings settings) {
    settings.groups = {};
    settings.weights = {};
    settings.rough = {};
    settings.classifier = nullptr;
    const glm::dvec3 site = fracture::bounds(input.model.mesh).centre();
    return fracture::fracture(input.model.mesh, {&site, 1}, settings);
}

} // namespace

Broken break_input(const Input& input, const FractureOptions& options, const std::function<void(double)>& progress,
                   fracture::Classifier* classifier, const std::function<bool()>& cancelled,
                   fracture::WorkLog* work_log) {
    const fracture::Settings settings{.algorithm = options.algorithm,
                                      .threads = options.threads,
                                      .groups = input.groups,
                                      .weights = input.weights,
                                      .min_volume = options.min_volume,
                                      .rough = roughness_of(options, input.scale),
                                      .classifier = classifier,
                                      .work_log = work_log,
                                      .progress = progress,
                                      .cancelled = cancelled};
    const Stopwatch stopwatch;
    Broken broken;
    broken.fragments = must(starts_whole(options.world) ? uncut(input, settings)
                                                        : fracture::fracture(input.model.mesh, input.sites, settings));
    broken.milliseconds = stopwatch.milliseconds();
    if (!starts_whole(options.world)) broken.rough = settings.rough;
    broken.certificate = fracture::certify(input.model.mesh, broken.fragments);
    const fracture::Certificate& c = broken.certificate;
    if (c.pieces == 0 || c.negative_pieces > 0 || c.volume_error > fracture::max_volume_error)
        throw Failure(exit_mesh, input.name + ": the pieces do not make up the mesh: " + std::to_string(c.pieces)
                                     + " pieces, " + std::to_string(c.negative_pieces)
                                     + " of them without positive volume, relative volume error "
                                     + std::to_string(c.volume_error) + "; please report this mesh with these options");
    return broken;
}

} // namespace brittle::tools

// From command-line words to a mesh, sites and fragments; shared by all commands. Errors are thrown (failure.h).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "fracture/fracture.h"
#include "fracture/io/model.h"
#include "fracture/sites/pattern.h"
#include "tools/brittle/recipe/picture_options.h"
#include "tools/brittle/recipe/strike.h"
#include "tools/brittle/recipe/world_options.h"

namespace brittle::tools {

// A site by itself, in the coordinates of the mesh.
struct PlacedSite {
    glm::dvec3 at{0.0};
    double weight = 0.0; // m^2, of fracture::Settings::weights
    uint32_t group = 0;  // sites of one number make one piece (fracture::Settings::groups); 0: by itself

    friend bool operator==(const PlacedSite&, const PlacedSite&) = default;
};

struct FractureOptions {
    std::string mesh;               // a file, or shape:NAME
    std::string material;           // --material: the name of a preset, or empty; its pattern is in `pattern` already
    fracture::Pattern pattern;      // --pattern, -n, --seed and more: makes the sites
    std::string sites_file;         // --sites: takes the place of the pattern
    std::vector<PlacedSite> points; // outdo the file and the pattern
    std::vector<Strike> strikes;    // --strike: only what they hit breaks; outdo all sites, the pattern says how
    bool fit_sites = false;         // --fit-sites: moves and scales them onto the mesh's box, before the placement
    fracture::Placement sites_placement; // --turn-sites, --scale-sites, --move-sites
    std::string save_recipe;             // --save-recipe: where load_input() writes all this; or empty
    bool repair = false;                 // --repair: fracture::repair() first, and say what it did
    fracture::Algorithm algorithm = fracture::Algorithm::exact;
    double min_volume = 0.0; // --min-volume, m^3: smaller pieces join a neighbour
    uint32_t threads = 0;    // 0: one a core
    PictureOptions picture;  // what `brittle render` shows
    WorldOptions world;      // its seed and blows are not looked at: world_of()
};

// The world, in which blows cut by the pattern's seed: equal seeds, equal cuts. What starts whole is cut in the manner of the
// pattern (of slices and the like as by uniform), or along the diagram of sites_file, which is read here. Throws a
// Failure where it cannot be.
[[nodiscard]] WorldOptions world_of(const FractureOptions& options);

// A mesh and the sites to break it by.
struct Input {
    std::string name;      // the file's stem or the shape's name
    fracture::Model model; // without looks for shapes, and unless they are asked for
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // of the sites; or none
    std::vector<double> weights;  // of the sites, m^2; or none
    double import_milliseconds = 0.0;
};

struct Broken {
    fracture::Fragments fragments;
    fracture::Certificate certificate;
    double milliseconds = 0.0; // of the fracture, without the certificate
};

struct SiteSet {
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups;
    std::vector<double> weights;
};

// The sites that the options make for a mesh, in its coordinates. Throws a Failure.
[[nodiscard]] SiteSet sites_for(const FractureOptions& options, const fracture::TriangleMesh& mesh);

// Such sites as a recipe lists them: groups are numbered from 1, and none for a site that is alone in its own.
[[nodiscard]] std::vector<PlacedSite> placed_sites(const SiteSet& set);

// `shape:NAME` gives a procedural shape, anything else is read as a file. A pattern is placed in the mesh's box.
[[nodiscard]] Input load_input(const FractureOptions& options, bool with_looks = false);

// Takes over the preset's way to break; count, seed and the like stay. Throws a Failure with exit_usage for an unknown
// name, and says which there are.
void use_material(const std::string& name, FractureOptions& options);

// The mesh alone, as it is in the file.
[[nodiscard]] Input load_mesh_only(const std::string& mesh, bool with_looks = false);

// Makes the mesh fit to be broken: repairs it if the options say so; else throws a Failure with exit_mesh that names
// --repair where that would help.
void prepare_mesh(const FractureOptions& options, Input& input);

// Fractures, or leaves the mesh in one piece where options.world starts whole. With `progress` called, `classifier` asked,
// `cancelled` watched and `work_log` filled as in fracture::Settings; Ctrl+C cancels in any case.
[[nodiscard]] Broken break_input(const Input& input, const FractureOptions& options,
                                 const std::function<void(double)>& progress = {},
                                 fracture::Classifier* classifier = nullptr,
                                 const std::function<bool()>& cancelled = {}, fracture::WorkLog* work_log = nullptr);

} // namespace brittle::tools

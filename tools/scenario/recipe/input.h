// The input of a fracture: the options of the command line or a recipe, the mesh and the sites that they name, and the
// fracture itself. All commands share it. Errors are thrown as Failure (base/failure.h).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fracture/fracture.h"
#include "fracture/io/model.h"
#include "fracture/pieces/contacts.h"
#include "fracture/sites/pattern.h"
#include "fracture/unite/unite.h"
#include "tools/scenario/recipe/automatic_pattern.h"
#include "tools/scenario/recipe/export_settings.h"
#include "tools/scenario/recipe/glue.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/picture_options.h"
#include "tools/scenario/recipe/placement.h"
#include "tools/scenario/recipe/strike.h"
#include "tools/scenario/recipe/world_options.h"

namespace brittle::tools {

// A single site in the coordinates of the mesh.
struct PlacedSite {
    glm::dvec3 at{0.0};
    double weight = 0.0; // m^2, as in fracture::Settings::weights
    uint32_t group = 0;  // sites with equal numbers make one piece (fracture::Settings::groups); 0: a piece of its own

    friend bool operator==(const PlacedSite&, const PlacedSite&) = default;
};

// The length of a unit of a mesh file. `fit`: whatever makes the mesh 2 m long.
enum class LengthUnit { fit, metre, centimetre, millimetre, inch };

[[nodiscard]] const char* to_string(LengthUnit unit); // "fit", "m", "cm", "mm" or "inch"
[[nodiscard]] std::optional<LengthUnit> length_unit(const std::string& name);
[[nodiscard]] double metres_of(LengthUnit unit); // 1 for fit

struct SceneObject;
struct LevelRule;

// The nodes of a glTF file as objects of a scene (level.h).
struct Level {
    std::string mesh;          // path of the file; empty: the scene has no level
    ObjectPlacement placement; // from the file's coordinates, in metres, to the world
    std::vector<LevelRule> rules;
};

// A mesh and how to break it; or, with `objects` or a level, a scene of several.
struct FractureOptions {
    std::string mesh;     // path of a file, or shape:NAME; - with Host::standard_input
    std::string format;   // --format: of the mesh on standard input; empty: told by its bytes. No part of a recipe
    std::string material; // --material: name of a preset, or empty; use_material() has copied its pattern to `pattern`
    fracture::Pattern pattern;                 // --pattern, -n, --seed ...: generates the sites
    std::optional<AutomaticPattern> automatic; // kind and seed are the pattern's, and the mesh decides the rest
    std::string sites_file;                    // --sites: replaces the pattern
    std::vector<PlacedSite> points;            // sites listed one by one; override the file and the pattern
    std::vector<Strike> strikes; // --strike: only the balls that they hit break, by the pattern; override all sites
    bool fit_sites = false;      // --fit-sites: moves and scales the sites onto the mesh's box, before the placement
    fracture::Placement sites_placement; // --turn-sites, --scale-sites, --move-sites
    // --pieces-from: a glTF file in pieces; scene_of_pieces() makes a scene of it and the other options.
    std::string pieces_from;
    std::string save_recipe; // --save-recipe: file to which load_input() writes these options; or empty
    bool repair = false;     // --repair: fracture::repair() before the fracture, with a report
    bool unite = false;      // --unite: fracture::unite() after that, with a report
    fracture::Algorithm algorithm = fracture::Algorithm::exact;
    double min_volume = 0.0; // --min-volume, m^3: a smaller piece is merged with a neighbour
    // --roughness, --rough-size, --grain, --detail; in metres of the file. roughness_of() sets its seed.
    fracture::Roughness rough;
    uint32_t threads = 0;               // 0: one per core
    PictureOptions picture;             // contents of the pictures of `brittle render`
    ExportSettings exports;             // contents of the files of pieces, without the output
    WorldOptions world;                 // physics; world_of() sets its seed and blows
    LengthUnit units = LengthUnit::fit; // of the mesh files
    double piece_scale = 1.0;           // factor of the size of pieces of all automatic patterns of a scene
    // The objects of a scene, those of its level first. Of the members above, only units, threads, picture, exports,
    // save_recipe and the members of `world` that concern no single object then count.
    Level level;
    std::vector<SceneObject> objects;
    std::vector<Glue> glue; // between objects of the scene
};

// An object of a scene: a recipe of its own, and its place. It starts whole and breakable, unless its recipe's world or
// a member here says otherwise.
struct SceneObject {
    std::string name; // unique in the scene
    // Of the mesh file, which is glTF: the mesh is this node's alone, in the node's coordinates. Empty: the whole file.
    std::string node;
    ObjectPlacement placement;
    bool fixed = false;     // never moves or breaks, and collides with its surface; the mesh may be open
    bool shattered = false; // cut by its pattern at the start, into loose pieces
    // The nodes of its glTF file are its pieces, as they are; they touch each other within contact_tolerance.
    bool in_pieces = false;
    double contact_tolerance = fracture::ContactSettings{}.tolerance; // m
    // Without objects. Of its world, the members that concern one object count; where it is neither breakable nor
    // bonded nor shattered, the object is rigid.
    FractureOptions recipe;

    SceneObject();
};

// The first rule of a level whose conditions all hold for a node makes the node an object.
struct LevelRule {
    std::string node;     // pattern of its name with * and ?; empty: any
    std::string material; // pattern of the name of a material of its mesh; empty: any mesh
    // Custom properties: keys of `extras` of the node or else of its mesh, with their values as JSON.
    std::vector<std::pair<std::string, std::string>> extras;
    SceneObject then; // without name, mesh, node and placement
};

inline SceneObject::SceneObject() {
    recipe.world.breakable = true;
    recipe.world.height = 0.0;
}

[[nodiscard]] inline bool is_scene(const FractureOptions& options) {
    return !options.objects.empty() || !options.level.mesh.empty();
}

// The largest contact_tolerance, m.
inline constexpr double max_contact_tolerance = 1.0;

// Returns the options, or where they have pieces_from the scene of that one object, bonded and breakable: its material,
// physics and place of anchors are those of the options. Units of fit count as metres.
[[nodiscard]] FractureOptions scene_of_pieces(FractureOptions options);

// Returns the name of a mesh for people: the name of a shape, or the stem of a file; "mesh" for standard input.
[[nodiscard]] std::string mesh_name(const std::string& mesh);

// Limits of FractureOptions::rough, those of fracture().
inline constexpr double min_stretch = 1.0 / 16.0, max_stretch = 16.0; // length of a grain; 0 stands for no grain
inline constexpr uint32_t max_detail = 6;                             // octaves
inline constexpr double max_rough_size = 1e30;                        // m

// Returns the roughness of the cuts, with the pattern's seed. `scale`: metres of the mesh per metre of the file.
[[nodiscard]] fracture::Roughness roughness_of(const FractureOptions& options, double scale = 1.0);

// Returns the world of the options, with the pattern's seed as the seed of blows: equal seeds give equal cuts. In a
// world that starts whole, blows cut by the kind of the pattern (grid, slices, curve and curvature count as
// uniform) or along the diagram of sites_file, which is read here. `scale`: metres of the stage per metre of the file,
// for the roughness of blows. Throws a Failure if that file cannot be read.
[[nodiscard]] WorldOptions world_of(const FractureOptions& options, double scale = 1.0);

// A mesh and the sites to break it by.
struct Input {
    std::string name;                       // stem of the file, or name of the shape
    fracture::Model model;                  // materials and textures only on request, and never for shapes
    std::shared_ptr<const MeshLooks> looks; // for drawing (stage/mesh_looks.h); null without, and unless asked for
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups;       // group of each site; or empty
    std::vector<double> weights;        // weight of each site, m^2; or empty
    double scale = 1.0;                 // metres of this mesh per metre of the file; placed_on_stage() sets it
    LengthUnit units = LengthUnit::fit; // of the file
    double import_milliseconds = 0.0;
};

struct Broken {
    fracture::Fragments fragments;
    fracture::Certificate certificate;
    fracture::Roughness rough; // of the cuts; flat where nothing was cut
    double milliseconds = 0.0; // duration of the fracture, without the certificate
};

struct SiteSet {
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups;
    std::vector<double> weights;
};

// Returns the sites that the options give for a mesh, in its coordinates. Throws a Failure.
[[nodiscard]] SiteSet sites_for(const FractureOptions& options, const fracture::TriangleMesh& mesh);

// Returns the sites in the form in which a recipe lists them: groups are numbered from 1, and a site that is alone in
// its group has number 0.
[[nodiscard]] std::vector<PlacedSite> placed_sites(const SiteSet& set);

// Throws a Failure with exit_usage for a scene. For commands that take one mesh.
void refuse_scene(const FractureOptions& options);

// Loads the mesh (`shape:NAME` is a procedural shape, any other name a file), writes save_recipe if it is set, prepares
// the mesh and generates the sites. A pattern is placed in the mesh's box. Throws a Failure. `with_looks`: with
// materials and textures.
[[nodiscard]] Input load_input(const FractureOptions& options, bool with_looks = false, const Host& host = {});

// Sets the material and copies the kind and shape of its fracture pattern, and its roughness except for the size; count,
// seed and the rest of the pattern stay. Throws a Failure with exit_usage that lists the presets if the name is unknown.
void use_material(const std::string& name, FractureOptions& options);

// Returns the grain of the options' material along an axis; zero for a material without one.
[[nodiscard]] glm::dvec3 grain_of_material(const FractureOptions& options, const glm::dvec3& axis);

// Loads the mesh alone, without repair or checks. `format` as FractureOptions::format.
[[nodiscard]] Input load_mesh_only(const std::string& mesh, bool with_looks = false, const Host& host = {},
                                   const std::string& format = "");

// Drops all but the mesh.
void keep_mesh_only(fracture::Model& model);

// Repairs the mesh if the options ask for it. Otherwise throws a Failure with exit_mesh that names --repair if the mesh
// is not closed but repair would close it. Then unites its parts if the options ask for that; a mesh that is not closed
// is a Failure with exit_mesh.
void prepare_mesh(const FractureOptions& options, Input& input, const Host& host = {});

// Unites the parts of a closed mesh and returns the report. Throws a Failure with exit_mesh where it is not closed, and
// where nothing remains.
fracture::UniteReport unite_parts(fracture::Model& model, const std::string& name);

// Returns a clause for people about what a union would change, such as "its parts pass through each other, so 12 % of
// its volume counts twice"; empty where that is nothing but rounding, and where the mesh is not closed.
[[nodiscard]] std::string overlap_of(const fracture::TriangleMesh& mesh);
[[nodiscard]] std::string overlap_text(const fracture::UniteReport& report);

// Fractures the mesh; in a world that starts whole the mesh becomes one piece per island instead. `progress`,
// `classifier`, `cancelled` and `work_log` are as in fracture::Settings.
[[nodiscard]] Broken break_input(const Input& input, const FractureOptions& options,
                                 const std::function<void(double)>& progress = {},
                                 fracture::Classifier* classifier = nullptr,
                                 const std::function<bool()>& cancelled = {}, fracture::WorkLog* work_log = nullptr);

} // namespace brittle::tools

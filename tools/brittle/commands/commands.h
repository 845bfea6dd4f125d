// The commands of the `brittle` program: one struct of options and one function for each. The functions return the exit
// code or throw a Failure. command_line.h parses the options.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "fracture/doctor/repair.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/scenario/recipe/export_settings.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/recipe/view_options.h"

namespace brittle::tools {

struct FractureCommand {
    FractureOptions fracture;
    ExportSettings files;         // those of `fracture` that have an effect on the output, and the output
    std::string classify = "cpu"; // auto, cpu or gpu
    std::string report;           // file of the JSON; empty: none
    bool json = false;            // print the JSON instead of the text
};

struct RenderCommand {
    FractureOptions fracture;
    ViewOptions view;
    std::string output = "frame_%04d.png"; // empty: no pictures
    std::string video;                     // video file of all frames, by ffmpeg; empty: none
    std::string record;                    // file of the replay log; empty: none
    std::string ids;   // name, in the manner of `output`, of pictures of piece numbers (id_picture.h); empty: none
    std::string graph; // file of the frame graph, as DOT; empty: none
    std::string classify = "cpu"; // auto, cpu or gpu
    ExportSettings pieces; // files of the pieces at the end of the run, as FractureCommand::files; without output: none
    bool json = false;     // print JSON instead of text
};

struct ReplayCommand {
    std::string log;
    std::string pictures; // pictures, as RenderCommand::output; empty: none
    uint32_t every = 10;
    std::string video;    // empty: none
    uint32_t threads = 0; // threads of the fracture; 0: one per core
    // Files of the pieces at the end of the run, by the settings of the log's recipe and the options of the command
    // line, which win; without output: none. Throws a Failure for an option that has no effect. Never empty.
    std::function<ExportSettings(const FractureOptions& recipe)> pieces;
    ViewOptions view;
};

struct DemoCommand {
    FractureOptions fracture;
    std::string recipe; // file that `fracture` was read from; or empty
    ViewOptions view;
    std::string record;            // file of the replay log of the last break; empty: none
    double ui_scale = 0.0;         // scale of text and panels; 0: as the display reports it
    std::string classify = "auto"; // auto, cpu or gpu
};

struct ProfileCommand {
    FractureOptions fracture;
    ViewOptions view;
    ProfilePlan plan;    // --scenarios, and the options that override it
    ScenarioGroup lists; // --meshes, --counts, --classify
    bool json = false;
    std::string output;     // file of the JSON, besides standard output; empty: none
    std::string csv;        // file of the table with one line per phase; empty: none
    std::string trace;      // file of the time line; empty: none
    std::string compare;    // earlier profile to compare with; empty: none
    double threshold = 1.1; // ratio of medians and minima above which a time counts as slower
};

struct InspectCommand {
    std::string mesh;   // or the recipe of a scene
    std::string format; // as FractureOptions::format
    bool json = false;
    std::string marks;   // GLB file; empty: none
    std::string picture; // PNG file; empty: none
    ViewOptions view;    // size, device and quality of the picture
};

struct RepairCommand {
    std::string mesh;
    std::string format; // as FractureOptions::format
    std::string output; // file whose ending gives the format; empty for standard output
    std::string stream; // format of the mesh on standard output, as ExportSettings::stream; empty: none
    fracture::RepairSettings settings;
    bool unite = false; // the parts of the repaired mesh
};

// Returns exit_mesh if the mesh, or an object of the scene that should break, cannot be fractured.
int run_inspect(const InspectCommand& command);
int run_repair(const RepairCommand& command);
int run_fracture(const FractureCommand& command);
int run_render(const RenderCommand& command);
// Returns exit_differs if a state differs from the recorded one.
int run_replay(const ReplayCommand& command);
int run_demo(const DemoCommand& command);
// Returns exit_slower if --compare finds a slower time.
int run_profile(const ProfileCommand& command);

} // namespace brittle::tools

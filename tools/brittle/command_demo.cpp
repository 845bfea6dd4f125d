#include <array>
#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <imgui.h>

#include "engine/core/window.h"
#include "tools/brittle/classify_choice.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/interrupt.h"
#include "tools/brittle/replay/recorder.h"
#include "tools/brittle/stage.h"
#include "tools/brittle/view.h"

namespace brittle::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr float ball_speed = 14.0f; // m/s

struct KeyHelp {
    const char* key;
    const char* what;
};
constexpr std::array key_help{
    KeyHelp{"Space", "break the mesh and let the pieces fall"},
    KeyHelp{"F", "fire a ball at it: it stands, and breaks where it is hit"},
    KeyHelp{"R", "reset: the unbroken mesh again"},
    KeyHelp{"P", "pause and go on"},
    KeyHelp{"D", "physics debug drawer: collision hulls in red"},
    KeyHelp{"S", "Voronoi sites as red spheres"},
    KeyHelp{"N", "smooth or flat shading"},
    KeyHelp{"O", "edges of triangles"},
    KeyHelp{"H", "this help"},
    KeyHelp{"Esc", "quit"},
    KeyHelp{"left drag", "orbit"},
    KeyHelp{"right drag", "pan"},
    KeyHelp{"wheel", "zoom"},
};

// The windowed demo: its state, its keys, its overlay. The fracture runs on a worker, so the window never waits.
class Demo {
  public:
    Demo(const DemoCommand& command, const Input& input, const ClassifyChoice& choice, engine::Device& device,
         engine::Window& window, engine::Renderer& renderer)
        : command_(command), input_(input), choice_(choice), device_(device), window_(window), renderer_(renderer),
          stage_(renderer, input.model.mesh, command.fracture.material) {
        const float aspect = static_cast<float>(command.view.width) / static_cast<float>(command.view.height);
        orbit_ = engine::OrbitCamera::around(stage_view(stage_.home_bounds()), aspect);
        stage_.simulation().commit_as(physics::Timing::when_ready);
        show_title();
    }

    ~Demo() { closing_ = true; } // and `breaking_` waits for the worker, which stops for it
    Demo(const Demo&) = delete;
    Demo& operator=(const Demo&) = delete;

    [[nodiscard]] Simulation& simulation() { return stage_.simulation(); }

    void run() {
        must(renderer_.warm_up());
        Clock::time_point last = Clock::now();
        while (!window_.should_close()) {
            throw_if_interrupted();
            handle(window_.poll());
            take_pieces();
            const Clock::time_point now = Clock::now();
            const double seconds = std::chrono::duration<double>(now - last).count();
            last = now;
            smoothed_seconds_ += (seconds - smoothed_seconds_) * 0.1;
            if (!paused_) stage_.advance(seconds);
            engine::Scene scene = stage_.scene();
            scene.camera = orbit_.camera();
            scene.smooth = smooth_;
            scene.wireframe = wireframe_ && device_.has_line_mode();
            const bool drawn = must(renderer_.present(scene, [this] { overlay(); }));
            if (!drawn) std::this_thread::sleep_for(std::chrono::milliseconds(50)); // minimised
        }
    }

  private:
    void handle(const engine::Input& input) {
        if (!renderer_.ui_wants_mouse()) {
            orbit_.rotate(input.drag_left);
            orbit_.pan(input.drag_right + input.drag_middle);
            orbit_.zoom(input.scroll);
        }
        if (input.pressed(engine::Key::escape)) window_.close();
        if (input.pressed(engine::Key::space)) start_breaking();
        if (input.pressed('F')) fire();
        if (input.pressed('R')) {
            discard_ = breaking_.valid();
            pieces_.reset();
            fire_when_cut_ = false;
            stage_.reset(input_.model.mesh);
            show_title();
        }
        if (input.pressed('P')) paused_ = !paused_;
        if (input.pressed('D')) stage_.show_hulls(hulls_ = !hulls_);
        if (input.pressed('S')) {
            sites_ = !sites_;
            stage_.show_sites(sites_ ? std::span(input_.sites) : std::span<const glm::dvec3>());
        }
        if (input.pressed('N')) smooth_ = !smooth_;
        if (input.pressed('O')) wireframe_ = !wireframe_;
        if (input.pressed('H')) help_ = !help_;
    }

    void start_breaking() {
        if (breaking_.valid() || stage_.broken()) return;
        breaking_ = std::async(std::launch::async, [this, options = next_break()] {
            Broken broken =
                break_input(input_, options, {}, choice_.classifier.get(), [this] { return closing_.load(); });
            PreparedPieces ahead = prepare_pieces(broken.fragments, options.world, options.material);
            return Ready{std::move(broken), std::move(ahead), options.world};
        });
    }

    // What Space or F make of the whole mesh. F: breakable things stay whole and are cut where the ball hits, others are
    // cut and stay bonded. Space: all of it falls apart.
    [[nodiscard]] FractureOptions next_break() const {
        FractureOptions options = command_.fracture;
        if (fire_when_cut_ && !options.world.breakable) options.world.bonded = true;
        if (!fire_when_cut_ && starts_whole(options.world)) options.world.anchored = options.world.breakable = false;
        return options;
    }

    // From the eye to where it looks.
    void fire() {
        if (!stage_.broken()) {
            fire_when_cut_ = true;
            start_breaking();
            return;
        }
        const engine::Camera camera = orbit_.camera();
        const glm::vec3 direction = glm::normalize(camera.target - camera.eye);
        stage_.shoot({.from = camera.eye, .velocity = glm::dvec3(ball_speed * direction)});
    }

    // Puts the pieces on the stage when the worker is done with them.
    void take_pieces() {
        if (!breaking_.valid() || breaking_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
        Ready ready = breaking_.get();
        if (std::exchange(discard_, false)) return;
        stage_.stand(ready.broken.fragments, ready.world, std::move(ready.ahead));
        if (std::exchange(fire_when_cut_, false)) fire();
        pieces_ = {ready.broken.certificate, ready.broken.milliseconds};
        show_title();
    }

    void show_title() {
        const std::string state =
            pieces_ ? std::to_string(pieces_->certificate.pieces) + " pieces" : std::string("whole");
        window_.set_title("Brittle: " + input_.name + ", " + state);
    }

    void overlay() {
        constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize
                                           | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing
                                           | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs;
        ImGui::SetNextWindowPos({12.0f, 12.0f});
        ImGui::SetNextWindowBgAlpha(0.6f);
        ImGui::Begin("status", nullptr, fixed);
        ImGui::Text("%.0f frames/s  %s", 1.0 / smoothed_seconds_, device_.info().name.c_str());
        ImGui::Text("%s, %zu triangles, %zu sites", input_.name.c_str(), input_.model.mesh.triangles.size(),
                    input_.sites.size());
        if (pieces_) {
            ImGui::Text("%u pieces in %.1f ms, %s", pieces_->certificate.pieces, pieces_->milliseconds,
                        pieces_->certificate.closed ? "all closed" : "NOT ALL CLOSED");
            ImGui::Text("%zu awake%s", stage_.world().awake_count(), paused_ ? ", paused" : "");
        } else {
            ImGui::TextUnformatted(breaking_.valid() ? "breaking ..." : "Space breaks it");
        }
        ImGui::TextUnformatted("H lists the keys");
        ImGui::End();
        if (!help_) return;
        const ImVec2 size = ImGui::GetIO().DisplaySize;
        ImGui::SetNextWindowPos({size.x - 12.0f, 12.0f}, ImGuiCond_Always, {1.0f, 0.0f});
        ImGui::SetNextWindowBgAlpha(0.6f);
        ImGui::Begin("keys", nullptr, fixed);
        for (const KeyHelp& line : key_help) {
            ImGui::TextUnformatted(line.key);
            ImGui::SameLine(100.0f);
            ImGui::TextUnformatted(line.what);
        }
        ImGui::End();
    }

    struct Ready {
        Broken broken;
        PreparedPieces ahead;
        WorldOptions world;
    };
    struct Pieces {
        fracture::Certificate certificate;
        double milliseconds;
    };

    const DemoCommand& command_;
    const Input& input_;
    const ClassifyChoice& choice_;
    engine::Device& device_;
    engine::Window& window_;
    engine::Renderer& renderer_;
    Stage stage_;
    engine::OrbitCamera orbit_;
    std::atomic<bool> closing_ = false; // the worker reads it
    std::future<Ready> breaking_;
    std::optional<Pieces> pieces_;
    double smoothed_seconds_ = 1.0 / 60.0;
    bool discard_ = false; // R was pressed while the worker was busy
    bool fire_when_cut_ = false; // F was pressed before Space, and the worker is busy
    bool paused_ = false;
    bool hulls_ = false;
    bool sites_ = false;
    bool smooth_ = false;
    bool wireframe_ = false;
    bool help_ = false;
};

} // namespace

int run_demo(const DemoCommand& command) {
    catch_interrupts();
    const auto window = must(engine::Window::create(
        {.title = "Brittle", .width = command.view.width, .height = command.view.height}));
    const Input input = placed_on_stage(load_input(command.fracture), command.fracture.world);
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    {
        const ClassifyChoice choice =
            choose_classifier(classify_path(command.classify), *device, input, command.fracture);
        std::fprintf(stderr, "brittle: classification on the %s\n", choice.why.c_str());
        const auto renderer = must(engine::Renderer::create(*device, renderer_settings(command.view)));
        must(renderer->attach(*window));
        Recorder recorder(command.record, command.fracture);
        Demo demo(command, input, choice, *device, *window, *renderer);
        if (!command.record.empty()) demo.simulation().observe(&recorder);
        demo.run();
        recorder.finish();
    }
    check_validation(*device);
    return exit_success;
}

} // namespace brittle::tools

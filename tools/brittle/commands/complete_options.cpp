#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "fracture/shapes/shapes.h"
#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/completion.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

void add_complete(CLI::App& app, Run& run) {
    const auto shell = std::make_shared<std::string>();
    CLI::App& complete =
        *app.add_subcommand("complete", "Print the completion script of a shell: source <(brittle complete bash)");
    complete.group("");
    complete.add_option("shell", *shell, "Shell")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}))
        ->type_name("SHELL");
    complete.callback([&run, &app, shell] {
        run = [&app, shell] {
            const ProgramEntry program = option_table(app);
            std::vector<std::string> shapes;
            for (const std::string_view name : fracture::shape_names()) shapes.emplace_back(name);
            const auto script = *shell == "bash" ? bash_completion : *shell == "zsh" ? zsh_completion : fish_completion;
            std::fputs(script(program, shapes).c_str(), stdout);
            return exit_success;
        };
    });
}

} // namespace brittle::tools

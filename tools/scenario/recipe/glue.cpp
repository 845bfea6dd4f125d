#include "tools/scenario/recipe/glue.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "fracture/io/text_cursor.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

// After a mismatch only the last * takes one more byte.
bool fits_pattern(std::string_view pattern, std::string_view text) {
    size_t p = 0, t = 0;
    std::optional<std::pair<size_t, size_t>> retry; // behind the last *, and where the text goes on there
    while (t < text.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            retry = {++p, t};
        } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
            ++p, ++t;
        } else if (retry) {
            p = retry->first;
            t = ++retry->second;
        } else {
            return false;
        }
    }
    return pattern.find_first_not_of('*', p) == pattern.npos;
}

std::string refusal_of_glue(const SceneObject& object) {
    if (object.fixed || object.recipe.world.bonded || !(object.shattered || object.in_pieces)) return {};
    return "the object " + fracture::quoted(std::string_view(object.name))
           + " is loose pieces, which glue does not hold; make it \"bonded\": true";
}

void follow_objects(std::vector<Glue>& glue, const std::vector<SceneObject>& before,
                    const std::vector<SceneObject>& after) {
    const auto each_pattern = [&](const auto& visit) {
        for (Glue& entry : glue)
            for (std::string* pattern : {&entry.first, &entry.second}) visit(*pattern);
    };
    if (before.size() == after.size())
        each_pattern([&](std::string& pattern) {
            const auto at = std::ranges::find(before, pattern, &SceneObject::name);
            if (at != before.end()) pattern = after[static_cast<size_t>(at - before.begin())].name;
        });
    std::erase_if(glue, [&](const Glue& entry) {
        const auto is_lost = [&](const std::string& pattern) {
            const auto fits = [&](const SceneObject& object) { return fits_pattern(pattern, object.name); };
            return std::ranges::any_of(before, fits) && std::ranges::none_of(after, fits);
        };
        return is_lost(entry.first) || is_lost(entry.second);
    });
}

} // namespace brittle::tools

// Glue: which objects of a scene hold together where they touch.
//
//     "glue": [{"between": ["shelf", "wall"]}, {"between": ["brick*", "brick*"], "strength": 0.1}]
//
// An entry glues each object that one pattern fits to each object that the other fits. The first entry that fits a pair
// decides for it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace brittle::tools {

struct SceneObject;

struct Glue {
    std::string first, second; // patterns of names of objects
    double strength = 1.0;     // multiple of the strength of the weaker of the two materials
    double tolerance = 1e-3;   // m, the largest gap or overlap between two faces that it bonds

    friend bool operator==(const Glue&, const Glue&) = default;
};

inline constexpr size_t max_glue = 1000; // entries of a scene
// Contacts that hold objects together of which one starts whole and breaks; of one group of such objects.
inline constexpr size_t max_glue_joints = 100;
inline constexpr double min_glue_strength = 1e-6, max_glue_strength = 1e6;

// Returns whether a text fits a pattern, in which * stands for any text and ? for any byte. Linear memory, and time
// bounded by the product of the lengths.
[[nodiscard]] bool fits_pattern(std::string_view pattern, std::string_view text);

// Returns why an object cannot be glued, and what to do, for people; empty where it can. Loose pieces cannot be.
[[nodiscard]] std::string refusal_of_glue(const SceneObject& object);

// Follows an edit of the objects: a pattern that was the name of one object follows its new name, and entries that fit
// no object any more go.
void follow_objects(std::vector<Glue>& glue, const std::vector<SceneObject>& before,
                    const std::vector<SceneObject>& after);

} // namespace brittle::tools

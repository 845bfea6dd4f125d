// The interface of tools/compare for peers in C++. docs/benchmark.md describes the protocol and the file format.
//
//     struct Job {
//         explicit Job(const Task& task);   // what is not measured: conversion to the peer's own types
//         size_t run();                     // what is measured: breaks the mesh; returns the count of pieces
//         std::vector<Part> pieces() const; // the pieces of the last run
//     };
//     int main(int count, char** words) { return serve<Job>(count, words, "Peer 1.2"); }
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace brittle::comparison {

using Point = std::array<double, 3>;
using Corners = std::array<uint32_t, 3>;

// A closed triangle mesh, counter-clockwise seen from outside. A cell that does not exist has no triangles.
struct Part {
    std::vector<Point> points;
    std::vector<Corners> triangles;
};

struct Task {
    Part mesh;
    std::vector<Point> sites;
    std::vector<Part> cells; // of the sites, for peers that only intersect meshes: one a site, in a box around the mesh
    unsigned threads = 1;
    std::vector<std::string> words; // arguments of the adapter itself
};

// Throws std::runtime_error where the file is missing or too short.
inline std::vector<Part> read_parts(const std::string& name) {
    std::ifstream in(name, std::ios::binary | std::ios::ate);
    if (!in) throw std::runtime_error(name + ": cannot be read");
    auto left = static_cast<uint64_t>(in.tellg());
    in.seekg(0);
    const auto take = [&](void* to, uint64_t bytes) {
        if (bytes > left || !in.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)))
            throw std::runtime_error(name + ": ends within a part; make it again");
        left -= bytes;
    };
    uint32_t count = 0;
    take(&count, sizeof count);
    std::vector<Part> parts;
    for (uint32_t k = 0; k < count; ++k) {
        std::array<uint32_t, 2> sizes{};
        take(sizes.data(), sizeof sizes);
        if (sizes[0] * uint64_t{sizeof(Point)} + sizes[1] * uint64_t{sizeof(Corners)} > left)
            throw std::runtime_error(name + ": part " + std::to_string(k) + " is larger than the file; make it again");
        Part& part = parts.emplace_back();
        part.points.resize(sizes[0]);
        part.triangles.resize(sizes[1]);
        take(part.points.data(), part.points.size() * sizeof(Point));
        take(part.triangles.data(), part.triangles.size() * sizeof(Corners));
        for (const Corners& corners : part.triangles)
            for (const uint32_t corner : corners)
                if (corner >= sizes[0])
                    throw std::runtime_error(name + ": part " + std::to_string(k) + " names vertex "
                                             + std::to_string(corner) + " of " + std::to_string(sizes[0]));
    }
    return parts;
}

inline void write_parts(const std::string& name, const std::vector<Part>& parts) {
    std::ofstream out(name, std::ios::binary);
    const auto put = [&](const void* from, size_t bytes) {
        out.write(static_cast<const char*>(from), static_cast<std::streamsize>(bytes));
    };
    const auto count = static_cast<uint32_t>(parts.size());
    put(&count, sizeof count);
    for (const Part& part : parts) {
        const std::array<uint32_t, 2> sizes{static_cast<uint32_t>(part.points.size()),
                                            static_cast<uint32_t>(part.triangles.size())};
        put(sizes.data(), sizeof sizes);
        put(part.points.data(), part.points.size() * sizeof(Point));
        put(part.triangles.data(), part.triangles.size() * sizeof(Corners));
    }
    if (!out.flush()) throw std::runtime_error(name + ": cannot be written");
}

// One site a line, three numbers.
inline std::vector<Point> read_sites(const std::string& name) {
    std::ifstream in(name);
    if (!in) throw std::runtime_error(name + ": cannot be read");
    std::vector<Point> sites;
    for (Point site; in >> site[0] >> site[1] >> site[2];) sites.push_back(site);
    if (!in.eof()) throw std::runtime_error(name + ": line " + std::to_string(sites.size() + 1) + " is no site");
    return sites;
}

// Called as: ADAPTER MESH SITES CELLS THREADS [WORD...]. Answers the lines of its standard input until that ends.
template<class Job>
int serve(int count, char** words, const std::string& version) {
    if (count < 5) {
        std::cerr << "usage: " << words[0] << " MESH SITES CELLS THREADS, see docs/benchmark.md\n";
        return 2;
    }
    std::optional<Job> job;
    try {
        Task task;
        task.mesh = read_parts(words[1]).at(0);
        task.sites = read_sites(words[2]);
        task.cells = read_parts(words[3]);
        task.threads = static_cast<unsigned>(std::stoul(words[4]));
        task.words.assign(words + 5, words + count);
        job.emplace(task);
    } catch (const std::exception& error) {
        std::cout << "failed " << error.what() << std::endl;
        return 1;
    }
    std::cout << "ready " << version << std::endl;
    for (std::string line; std::getline(std::cin, line);) {
        try {
            if (line == "run") {
                const auto begin = std::chrono::steady_clock::now();
                const size_t pieces = job->run();
                const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
                std::cout << "done " << time.count() << ' ' << pieces << std::endl;
            } else if (line.starts_with("write ")) {
                write_parts(line.substr(6), job->pieces());
                std::cout << "written" << std::endl;
            }
        } catch (const std::exception& error) {
            std::cout << "failed " << error.what() << std::endl;
        }
    }
    return 0;
}

} // namespace brittle::comparison

#include "bindings/c/brittle.h"

#include "bindings/c/handles.h"

using namespace brittle;

extern "C" {

const char* brittle_status_name(brittle_status status) {
    switch (status) {
    case BRITTLE_OK:
        return "ok";
    case BRITTLE_INVALID_ARGUMENT:
        return "invalid_argument";
    case BRITTLE_OUT_OF_MEMORY:
        return "out_of_memory";
    case BRITTLE_INTERNAL_ERROR:
        return "internal_error";
    default:
        if (status < BRITTLE_FILE_NOT_FOUND || status > BRITTLE_WRITE_FAILED) return "unknown";
        return fracture::to_string(static_cast<fracture::Status>(status - 1));
    }
}

const char* brittle_version(void) {
    return BRITTLE_VERSION;
}

const char* brittle_text_get(const brittle_text* text) {
    return text ? text->text.c_str() : "";
}

void brittle_text_free(brittle_text* text) {
    delete text;
}

uint64_t brittle_files_count(const brittle_files* files) {
    return files ? files->files.size() : 0;
}

brittle_status brittle_files_get(const brittle_files* files, uint64_t k, const char** name, const void** bytes,
                                 size_t* size, brittle_error* error) {
    return c::guarded(error, [&] {
        const auto& all = c::need(files, "files").files;
        if (k >= all.size())
            c::refuse("there is no file " + std::to_string(k) + "; there are " + std::to_string(all.size()));
        if (name) *name = all[k].name.c_str();
        if (bytes) *bytes = all[k].bytes.data();
        if (size) *size = all[k].bytes.size();
    });
}

void brittle_files_free(brittle_files* files) {
    delete files;
}

} // extern "C"

#include "engine/core/result.h"

namespace brittle::engine {

const char* to_string(Status status) {
    switch (status) {
    case Status::no_driver:
        return "no_driver";
    case Status::no_device:
        return "no_device";
    case Status::missing_feature:
        return "missing_feature";
    case Status::no_display:
        return "no_display";
    case Status::device_lost:
        return "device_lost";
    case Status::device_failure:
        return "device_failure";
    case Status::out_of_memory:
        return "out_of_memory";
    case Status::invalid_argument:
        return "invalid_argument";
    case Status::file_error:
        return "file_error";
    }
    return "unknown";
}

} // namespace brittle::engine

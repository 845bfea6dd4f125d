#include "tools/brittle/base/device_failure.h"

namespace brittle::tools {

namespace {

ExitCode exit_code(engine::Status status) {
    using engine::Status;
    switch (status) {
    case Status::no_driver:
    case Status::no_device:
    case Status::missing_feature:
    case Status::no_display:
    case Status::device_lost:
        return exit_environment;
    case Status::invalid_argument:
        return exit_usage;
    case Status::file_error:
        return exit_output;
    case Status::device_failure:
    case Status::out_of_memory:
        return exit_failure;
    }
    return exit_failure;
}

} // namespace

Failure failure_of(const engine::Error& error) {
    return {exit_code(error.status), error.message};
}

} // namespace brittle::tools

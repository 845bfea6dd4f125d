# The headers of Debian's nlohmann-json3-dev, which is for every platform.
add_library(nlohmann_json::nlohmann_json INTERFACE IMPORTED)
target_include_directories(nlohmann_json::nlohmann_json INTERFACE ${WEB_HEADERS})
set(nlohmann_json_FOUND TRUE)

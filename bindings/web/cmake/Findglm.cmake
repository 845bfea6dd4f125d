# The headers of Debian's libglm-dev, which is for every platform. WEB_HEADERS: tools/build-web links them there.
add_library(glm::glm INTERFACE IMPORTED)
target_include_directories(glm::glm INTERFACE ${WEB_HEADERS})
set(glm_FOUND TRUE)

# Installs the libraries, builds the consumers against them (by find_package and by pkg-config) and runs both.
#   cmake -D BUILD=... -D SOURCE=... -D COMPILER=... -D FLAGS=... -D MESH=... [-D SHARED=ROOT] -P test.cmake
# With SHARED, the root of the repository, the libraries are first built as shared ones, in BUILD/consumer_shared.
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(work ${BUILD}/consumer)
if(SHARED)
    set(work ${BUILD}/consumer_shared)
    run(${CMAKE_COMMAND} -G Ninja -S ${SHARED} -B ${work}/library -D BRITTLE_LIBRARY_ONLY=ON -D BUILD_SHARED_LIBS=ON
        -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_BUILD_TYPE=Release -D BUILD_TESTING=OFF
        -D BRITTLE_WARNINGS_AS_ERRORS=ON) # the flags of the presets, for ccache
    run(${CMAKE_COMMAND} --build ${work}/library)
    set(BUILD ${work}/library)
endif()
file(REMOVE_RECURSE ${work}/prefix ${work}/build)
run(${CMAKE_COMMAND} --install ${BUILD} --component library --prefix ${work}/prefix)
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${work}/build -D CMAKE_PREFIX_PATH=${work}/prefix
    -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/consumer ${MESH})
run(${work}/build/consumer_physics)

file(GLOB_RECURSE pc ${work}/prefix/*/brittle.pc)
cmake_path(GET pc PARENT_PATH pc_dir)
cmake_path(GET pc_dir PARENT_PATH lib_dir)
set(ENV{PKG_CONFIG_PATH} ${pc_dir})
set(ENV{LD_LIBRARY_PATH} ${lib_dir})
foreach(pair "main brittle" "physics brittle-physics")
    separate_arguments(pair UNIX_COMMAND ${pair})
    list(POP_FRONT pair source package)
    execute_process(COMMAND pkg-config --define-variable=prefix=${work}/prefix --cflags --libs ${package}
        OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(flags UNIX_COMMAND "${FLAGS} ${flags}")
    run(${COMPILER} -std=c++20 ${SOURCE}/${source}.cpp -o ${work}/${source}_by_pkg_config ${flags})
    run(${work}/${source}_by_pkg_config ${MESH})
endforeach()

if(SHARED)
    # The libraries that are inside stay inside: nothing but namespace brittle is exported.
    foreach(name fracture physics)
        execute_process(COMMAND nm -DC --defined-only ${lib_dir}/libbrittle_${name}.so
            OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
        string(REGEX MATCH "[^\n]* [TWVBDRu] (std::|bt[A-Z]|nlohmann|tbb|boost)[^\n]*" foreign "${symbols}")
        if(foreign)
            message(FATAL_ERROR "libbrittle_${name}.so exports a symbol of another library: ${foreign}")
        endif()
        if(NOT symbols MATCHES "brittle::${name}::")
            message(FATAL_ERROR "libbrittle_${name}.so exports nothing")
        endif()
    endforeach()
endif()

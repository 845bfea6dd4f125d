# Adds the guard's probe to any commit of Brittle, at the end of its configuration:
#   cmake ... -DCMAKE_PROJECT_brittle_INCLUDE=guard.cmake -DGUARD_PROBE=probe.cpp
if(NOT GUARD_PROBE)
    message(FATAL_ERROR "guard.cmake needs -DGUARD_PROBE=FILE")
endif()
function(add_guard)
    add_executable(brittle_guard ${GUARD_PROBE})
    target_link_libraries(brittle_guard PRIVATE brittle_fracture brittle_physics)
endfunction()
cmake_language(DEFER CALL add_guard)

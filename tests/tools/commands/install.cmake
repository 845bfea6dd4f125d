# Installs the program with its help into a folder, and runs it there.
#   cmake -D BUILD=FOLDER -D WORK=FOLDER -P install.cmake
file(REMOVE_RECURSE ${WORK})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --component program --prefix ${WORK}
    COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
set(installed
    bin/brittle
    share/bash-completion/completions/brittle
    share/zsh/site-functions/_brittle
    share/fish/vendor_completions.d/brittle.fish
    share/man/man1/brittle.1)
file(GLOB_RECURSE found RELATIVE ${WORK} ${WORK}/*)
list(SORT found)
list(SORT installed)
if(NOT found STREQUAL installed)
    message(FATAL_ERROR "installed: ${found}\nexpected: ${installed}")
endif()
set(bin ${WORK}/bin/brittle)
foreach(help
        "share/bash-completion/completions/brittle;complete;bash"
        "share/zsh/site-functions/_brittle;complete;zsh"
        "share/fish/vendor_completions.d/brittle.fish;complete;fish"
        "share/man/man1/brittle.1;help;--man")
    list(POP_FRONT help file)
    execute_process(COMMAND ${bin} ${help} OUTPUT_VARIABLE expected COMMAND_ERROR_IS_FATAL ANY)
    file(READ ${WORK}/${file} text)
    if(NOT text STREQUAL expected)
        message(FATAL_ERROR "${file} is not what brittle ${help} prints")
    endif()
endforeach()
file(REMOVE_RECURSE ${WORK})

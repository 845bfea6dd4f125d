/* A host that unloads its plugins: its threads must not be left without code. test_unload LIBRARY */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "brittle.h"

static void* symbol(void* library, const char* name) {
    void* found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return found;
}

int main(int count, char** arguments) {
    brittle_mesh* mesh = NULL;
    brittle_sites* sites = NULL;
    brittle_pieces* pieces = NULL;
    brittle_status (*shape)(const char*, brittle_mesh**, brittle_error*);
    brittle_status (*pattern)(const brittle_pattern*, const brittle_mesh*, brittle_sites**, brittle_error*);
    brittle_status (*fracture)(const brittle_mesh*, const brittle_sites*, const brittle_fracture_settings*,
                               brittle_pieces**, brittle_error*);
    void* library = count == 2 ? dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library) return puts("usage: test_unload LIBRARY"), 2;
    /* ISO C has no conversion from data to functions; POSIX has this one. */
    *(void**)&shape = symbol(library, "brittle_mesh_shape");
    *(void**)&pattern = symbol(library, "brittle_sites_pattern");
    *(void**)&fracture = symbol(library, "brittle_fracture");
    if (shape("icosphere:5", &mesh, NULL) || pattern(NULL, mesh, &sites, NULL)
        || fracture(mesh, sites, NULL, &pieces, NULL))
        return puts("the fracture failed"), 1;
    dlclose(library);
    if (!dlopen(arguments[1], RTLD_NOW | RTLD_NOLOAD)) return puts("the library was unloaded under its threads"), 1;
    return 0;
}

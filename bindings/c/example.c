/* Breaks a mesh into a hundred pieces and writes them: example MESH OUTPUT
 *
 *     cc example.c $(pkg-config --cflags --libs brittle-c) -o example */
#include <stdio.h>

#include <brittle.h>

int main(int count, char** arguments) {
    brittle_error error = {sizeof error, BRITTLE_OK, ""};
    brittle_mesh* mesh = NULL;
    brittle_sites* sites = NULL;
    brittle_pieces* pieces = NULL;
    brittle_pattern pattern;
    brittle_certificate certificate = {sizeof certificate};
    if (count != 3) return puts("usage: example MESH OUTPUT"), 2;
    brittle_pattern_init(&pattern, sizeof pattern);
    pattern.count = 100;
    if (brittle_mesh_load(arguments[1], &mesh, &error) || brittle_sites_pattern(&pattern, mesh, &sites, &error)
        || brittle_fracture(mesh, sites, NULL, &pieces, &error)
        || brittle_pieces_certificate(pieces, &certificate, &error)
        || brittle_pieces_save(pieces, arguments[2], NULL, &error))
        fprintf(stderr, "%s\n", error.message);
    else
        printf("%u pieces, %s\n", certificate.pieces, certificate.closed ? "all closed" : "not all closed");
    brittle_pieces_free(pieces);
    brittle_sites_free(sites);
    brittle_mesh_free(mesh);
    return error.status == BRITTLE_OK && certificate.closed ? 0 : 1;
}

/* Recipes, runs and replays through the C interface. Prints each check that fails; exit code 1 if there is one.
 *   test_runs FOLDER                  all checks; writes files into the folder
 *   test_runs --hash RECIPE           the hash of the recipe's pieces
 *   test_runs --record RECIPE LOG     runs the recipe for 60 steps, with a shot, and writes its log
 *   test_runs --replay LOG            replays a log; exit code 1 where it differs */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "brittle.h"
#include "checks.h"

/* Ends the program where the call fails. */
static void must(brittle_status status, const brittle_error* error) {
    if (status == BRITTLE_OK) return;
    fprintf(stderr, "%s: %s\n", brittle_status_name(status), error->message);
    exit(1);
}

static brittle_recipe* parsed(const char* json) {
    brittle_error error = {sizeof error, 0, ""};
    brittle_recipe* recipe = NULL;
    must(brittle_recipe_parse(json, NULL, &recipe, &error), &error);
    return recipe;
}

static brittle_run* started(const char* json) {
    brittle_error error = {sizeof error, 0, ""};
    brittle_recipe* recipe = parsed(json);
    brittle_run* run = NULL;
    must(brittle_run_start(recipe, NULL, &run, &error), &error);
    brittle_recipe_free(recipe); /* the run does not need it */
    return run;
}

static uint64_t hash_of(const brittle_run* run) {
    uint64_t hash = 0;
    CHECK(brittle_run_state_hash(run, &hash, NULL) == BRITTLE_OK);
    return hash;
}

static const char* const shot =
    "{\"shoot\": {\"from\": [0, 1, 4], \"velocity\": [0, 0, -25], \"radius\": 0.2, \"density\": 7800}}";

static const char* const breakable = "{\"brittle\": 1, \"mesh\": \"shape:cube\", \"material\": \"stone\", \"world\": "
                                     "{\"breakable\": true, \"height\": 0}}";

static void test_recipes(const char* folder) {
    brittle_recipe *recipe = NULL, *again = NULL;
    brittle_text *text = NULL, *same = NULL;
    char path[512];
    CHECK_ERROR(brittle_recipe_parse(NULL, NULL, &recipe, &error), BRITTLE_INVALID_ARGUMENT, "json is NULL");
    CHECK_ERROR(brittle_recipe_parse("{", NULL, &recipe, &error), BRITTLE_MALFORMED_FILE, "recipe");
    CHECK_ERROR(brittle_recipe_parse("{\"brittle\": 1, \"mehs\": \"shape:cube\"}", NULL, &recipe, &error),
                BRITTLE_MALFORMED_FILE, "mehs");
    CHECK_ERROR(brittle_recipe_load("/nonexistent.json", &recipe, &error), BRITTLE_FILE_NOT_FOUND, "nonexistent");
    CHECK_ERROR(brittle_recipe_load("", &recipe, &error), BRITTLE_INVALID_ARGUMENT, "empty");
    CHECK(recipe == NULL);

    recipe = parsed("{\"brittle\": 1, \"mesh\": \"shape:torus\", \"pattern\": {\"count\": 20, \"seed\": 3}}");
    CHECK(brittle_recipe_text(recipe, &text, NULL) == BRITTLE_OK);
    CHECK(strstr(brittle_text_get(text), "\"seed\":3") != NULL);
    snprintf(path, sizeof path, "%s/saved.json", folder);
    CHECK(brittle_recipe_save(recipe, path, NULL) == BRITTLE_OK);
    CHECK(brittle_recipe_load(path, &again, NULL) == BRITTLE_OK);
    CHECK(brittle_recipe_text(again, &same, NULL) == BRITTLE_OK);
    CHECK(strcmp(brittle_text_get(text), brittle_text_get(same)) == 0);
    CHECK_ERROR(brittle_recipe_save(recipe, "/nonexistent/saved.json", &error), BRITTLE_WRITE_FAILED, "nonexistent");
    brittle_text_free(text);
    brittle_text_free(same);
    brittle_recipe_free(again);
    brittle_recipe_free(recipe);
    brittle_recipe_free(NULL);
}

static double last_share = 0.0;
static void remember(void* user, double share) {
    *(double*)user = share;
}
static int32_t yes(void* user) {
    (void)user;
    return 1;
}
static void copy(void* user, const char* text) {
    snprintf((char*)user, 200, "%s", text);
}

static void test_fractures(void) {
    brittle_recipe* recipe = parsed("{\"brittle\": 1, \"mesh\": \"shape:torus\", \"pattern\": {\"count\": 20}}");
    brittle_load_settings settings;
    brittle_pieces* pieces = NULL;
    brittle_array volumes;
    char told[200] = "";
    brittle_load_settings_init(&settings, sizeof settings);
    settings.progress = remember;
    settings.user = &last_share;
    CHECK(brittle_recipe_fracture(recipe, &settings, &pieces, NULL) == BRITTLE_OK);
    CHECK(brittle_pieces_array(pieces, BRITTLE_PIECES_VOLUMES, &volumes, NULL) == BRITTLE_OK);
    CHECK(volumes.rows >= 10);
    CHECK(last_share == 1.0);
    brittle_pieces_free(pieces);
    pieces = NULL;
    settings.cancelled = yes;
    CHECK_ERROR(brittle_recipe_fracture(recipe, &settings, &pieces, &error), BRITTLE_CANCELLED, "");
    settings.cancelled = NULL;
    settings.threads = 2000;
    CHECK_ERROR(brittle_recipe_fracture(recipe, &settings, &pieces, &error), BRITTLE_INVALID_SETTING, "threads");
    CHECK(pieces == NULL);
    brittle_recipe_free(recipe);

    recipe = parsed("{\"brittle\": 1, \"mesh\": \"shape:cube\", \"repair\": true, \"pattern\": {\"count\": 3}}");
    brittle_load_settings_init(&settings, sizeof settings);
    settings.report = copy;
    settings.user = told;
    CHECK(brittle_recipe_fracture(recipe, &settings, &pieces, NULL) == BRITTLE_OK);
    CHECK(strcmp(told, "cube: nothing to repair") == 0);
    brittle_pieces_free(pieces);
    pieces = NULL;
    brittle_recipe_free(recipe);

    recipe = parsed("{\"brittle\": 1, \"mesh\": \"/nonexistent.obj\"}");
    CHECK_ERROR(brittle_recipe_fracture(recipe, NULL, &pieces, &error), BRITTLE_FILE_NOT_FOUND, "nonexistent");
    brittle_recipe_free(recipe);
    recipe = parsed("{\"brittle\": 2, \"objects\": [{\"name\": \"a\", \"mesh\": \"shape:cube\"}]}");
    CHECK_ERROR(brittle_recipe_fracture(recipe, NULL, &pieces, &error), BRITTLE_INVALID_SETTING, "scene");
    brittle_recipe_free(recipe);
}

/* Pieces that are not breakable: they keep their numbers, and fall. */
static void test_loose_pieces(void) {
    brittle_run* run = started("{\"brittle\": 1, \"mesh\": \"shape:cube\", \"pattern\": {\"count\": 12, \"seed\": 2}, "
                               "\"world\": {\"bonded\": false, \"height\": 1}}");
    brittle_pieces* pieces = NULL;
    brittle_array volumes;
    brittle_transform before[64], after[64];
    brittle_events* events = NULL;
    brittle_array added;
    uint64_t count = 0, steps = 99, k;
    double seconds = 0.0;
    CHECK(brittle_run_object_pieces(run, 0, &pieces, NULL) == BRITTLE_OK);
    CHECK(brittle_pieces_array(pieces, BRITTLE_PIECES_VOLUMES, &volumes, NULL) == BRITTLE_OK);
    CHECK(brittle_run_transforms(run, NULL, 0, &count, NULL) == BRITTLE_OK);
    CHECK(count == volumes.rows && count <= 64);
    CHECK(brittle_run_transforms(run, before, 64, NULL, NULL) == BRITTLE_OK);
    CHECK(brittle_run_time(run, &steps, &seconds, NULL) == BRITTLE_OK);
    CHECK(steps == 0 && seconds > 0.0083 && seconds < 0.0084);
    CHECK(brittle_run_step(run, 24, NULL) == BRITTLE_OK); /* 0.2 s: 0.2 m of free fall */
    CHECK(brittle_run_transforms(run, after, 64, NULL, NULL) == BRITTLE_OK);
    for (k = 0; k < count; ++k) {
        CHECK(after[k].piece == k && after[k].slot == k);
        CHECK(before[k].position[1] - after[k].position[1] > 0.17f);
        CHECK(before[k].position[1] - after[k].position[1] < 0.23f);
    }
    CHECK(brittle_run_events(run, &events, NULL) == BRITTLE_OK);
    CHECK(brittle_events_array(events, BRITTLE_EVENTS_ADDED, &added, NULL) == BRITTLE_OK);
    CHECK(added.rows == 0);
    brittle_events_free(events);
    brittle_pieces_free(pieces);
    brittle_run_free(run);
}

/* A shot breaks a stone; its pieces come as events. */
static void test_blows(const char* folder) {
    brittle_run *run = started(breakable), *same = started(breakable);
    brittle_events* events = NULL;
    brittle_array added, positions;
    brittle_ball ball;
    brittle_replay_result result;
    brittle_load_settings settings;
    char path[512];
    uint64_t balls = 0;
    uint32_t exterior = 0;
    CHECK(brittle_run_events(run, &events, NULL) == BRITTLE_OK);
    CHECK(brittle_events_array(events, BRITTLE_EVENTS_ADDED, &added, NULL) == BRITTLE_OK);
    CHECK(added.rows == 1);
    CHECK(brittle_events_added_array(events, 0, BRITTLE_ADDED_POSITIONS, &positions, &exterior, NULL) == BRITTLE_OK);
    CHECK(positions.rows >= 8 && exterior == 12);
    brittle_events_free(events);

    CHECK_ERROR(brittle_run_act(run, "{", &error), BRITTLE_MALFORMED_FILE, "action");
    CHECK_ERROR(brittle_run_act(run, "{\"jump\": {}}", &error), BRITTLE_MALFORMED_FILE, "jump");
    CHECK_ERROR(brittle_run_act(run, "{}", &error), BRITTLE_INVALID_ARGUMENT, "shoot");
    CHECK_ERROR(brittle_run_act(run, "{\"shoot\": {\"from\": [0, 1, 4]}}", &error), BRITTLE_MALFORMED_FILE, "velocity");
    CHECK_ERROR(
        brittle_run_act(run, "{\"hammer\": {\"piece\": 77, \"point\": [0, 0, 0], \"impulse\": [0, 0, 1]}}", &error),
        BRITTLE_MALFORMED_FILE, "piece");

    CHECK(brittle_run_act(run, shot, NULL) == BRITTLE_OK);
    CHECK(brittle_run_act(same, shot, NULL) == BRITTLE_OK);
    CHECK(brittle_run_balls(run, &ball, 1, &balls, NULL) == BRITTLE_OK);
    CHECK(balls == 1 && ball.radius == 0.2f && ball.position[2] == 4.0f);
    CHECK(brittle_run_step(run, 60, NULL) == BRITTLE_OK);
    CHECK(brittle_run_step(same, 20, NULL) == BRITTLE_OK);
    CHECK(hash_of(run) != hash_of(same));
    CHECK(brittle_run_step(same, 40, NULL) == BRITTLE_OK);
    CHECK(hash_of(run) == hash_of(same));
    CHECK(brittle_run_events(run, &events, NULL) == BRITTLE_OK);
    CHECK(brittle_events_array(events, BRITTLE_EVENTS_ADDED, &added, NULL) == BRITTLE_OK);
    CHECK(added.rows > 4);
    brittle_events_free(events);

    snprintf(path, sizeof path, "%s/run.log", folder);
    CHECK(brittle_run_save_log(run, path, NULL) == BRITTLE_OK);
    CHECK_ERROR(brittle_run_save_log(run, "/nonexistent/run.log", &error), BRITTLE_WRITE_FAILED, "nonexistent");
    memset(&result, 0, sizeof result);
    result.struct_size = sizeof result;
    brittle_load_settings_init(&settings, sizeof settings);
    settings.threads = 1;
    CHECK(brittle_replay(path, &settings, &result, NULL) == BRITTLE_OK);
    CHECK(result.is_equal == 1 && result.steps == 60 && result.actions == 1 && result.difference[0] == '\0');
    CHECK(result.state_hash == hash_of(run));
    settings.cancelled = yes;
    CHECK_ERROR(brittle_replay(path, &settings, &result, &error), BRITTLE_CANCELLED, "");
    CHECK_ERROR(brittle_replay("/nonexistent.log", NULL, &result, &error), BRITTLE_FILE_NOT_FOUND, "nonexistent");
    brittle_run_free(run);
    brittle_run_free(same);
    brittle_run_free(NULL);
}

/* A log whose shot was made slower: the replay says where it differs. */
static void test_difference(const char* folder) {
    char from[512], to[512], line[8192];
    brittle_replay_result result;
    FILE *in, *out;
    snprintf(from, sizeof from, "%s/run.log", folder);
    snprintf(to, sizeof to, "%s/other.log", folder);
    in = fopen(from, "r");
    out = fopen(to, "w");
    CHECK(in && out);
    if (!in || !out) return;
    while (fgets(line, sizeof line, in)) {
        char* speed = strstr(line, "-25");
        if (speed) speed[2] = '4';
        fputs(line, out);
    }
    fclose(in);
    fclose(out);
    memset(&result, 0, sizeof result);
    result.struct_size = sizeof result;
    CHECK(brittle_replay(to, NULL, &result, NULL) == BRITTLE_OK);
    CHECK(result.is_equal == 0 && result.first_difference == 1 && strstr(result.difference, "state hash"));
}

/* Copies a log whose recipe gives other pieces: `from` replaced by `to`, once. */
static void change_log(const char* log, const char* changed, const char* from, const char* to) {
    char line[8192];
    int done = 0;
    FILE* in = fopen(log, "r");
    FILE* out = fopen(changed, "w");
    CHECK(in && out);
    while (in && out && fgets(line, sizeof line, in)) {
        char* at = done ? NULL : strstr(line, from);
        if (at) {
            done = 1;
            fprintf(out, "%.*s%s%s", (int)(at - line), line, to, at + strlen(from));
        } else {
            fputs(line, out);
        }
    }
    CHECK(done);
    if (in) fclose(in);
    if (out) fclose(out);
}

/* Logs whose recipes give fewer or other pieces: no action of a log acts on them. */
static void test_other_pieces(const char* folder) {
    const char* const recipe = "{\"brittle\": 1, \"mesh\": \"shape:cube\", \"pattern\": {\"count\": %d, \"seed\": %d}}";
    const char* const changes[2][3] = {{"\"count\":12", "\"count\":3", "pieces were recorded"},
                                       {"\"seed\":77", "\"seed\":78", "the pieces are not those recorded"}};
    char text[256], log[512], changed[512];
    brittle_replay_result result;
    brittle_run* run;
    int k;
    snprintf(text, sizeof text, recipe, 12, 77);
    run = started(text);
    CHECK(brittle_run_act(run, "{\"hammer\": {\"piece\": 11, \"point\": [0, 1, 0], \"impulse\": [0, 0, 5000]}}", NULL)
          == BRITTLE_OK);
    CHECK(brittle_run_step(run, 2, NULL) == BRITTLE_OK);
    snprintf(log, sizeof log, "%s/pieces.log", folder);
    snprintf(changed, sizeof changed, "%s/other_pieces.log", folder);
    CHECK(brittle_run_save_log(run, log, NULL) == BRITTLE_OK);
    brittle_run_free(run);
    for (k = 0; k < 2; ++k) {
        change_log(log, changed, changes[k][0], changes[k][1]);
        memset(&result, 0, sizeof result);
        result.struct_size = sizeof result;
        CHECK(brittle_replay(changed, NULL, &result, NULL) == BRITTLE_OK);
        CHECK(result.is_equal == 0 && result.first_difference == 0 && result.actions == 1);
        CHECK(strstr(result.difference, changes[k][2]) != NULL);
        snprintf(text, sizeof text, recipe, k == 0 ? 3 : 12, k == 0 ? 77 : 78);
        run = started(text);
        CHECK(result.state_hash == hash_of(run)); /* as it was before any action */
        brittle_run_free(run);
    }
}

static void test_scene(void) {
    brittle_run* run = started("{\"brittle\": 2, \"objects\": ["
                               "{\"name\": \"floor\", \"mesh\": \"shape:cube\", \"fixed\": true, "
                               "\"scale\": [2, 0.1, 2], \"translation\": [0, 0.05, 0]}, "
                               "{\"name\": \"vase\", \"mesh\": \"shape:icosphere:2\", \"material\": \"ceramic\", "
                               "\"scale\": [0.3, 0.3, 0.3], \"translation\": [0, 1, 0]}]}");
    brittle_run_object object;
    brittle_text* notes = NULL;
    brittle_mesh* mesh = NULL;
    brittle_pieces* pieces = NULL;
    uint32_t count = 0;
    CHECK(brittle_run_object_count(run, &count, NULL) == BRITTLE_OK && count == 2);
    memset(&object, 0, sizeof object);
    object.struct_size = sizeof object;
    CHECK(brittle_run_object_get(run, 0, &object, NULL) == BRITTLE_OK);
    CHECK(object.is_fixed == 1 && strcmp(object.name, "floor") == 0 && object.piece_count == 1);
    CHECK(brittle_run_object_get(run, 1, &object, NULL) == BRITTLE_OK);
    CHECK(object.is_fixed == 0 && strcmp(object.material, "ceramic") == 0 && object.position[1] == 1.0f);
    CHECK_ERROR(brittle_run_object_get(run, 2, &object, &error), BRITTLE_INVALID_ARGUMENT, "there are 2");
    CHECK_ERROR(brittle_run_object_pieces(run, 0, &pieces, &error), BRITTLE_INVALID_ARGUMENT, "fixed");
    CHECK(brittle_run_object_mesh(run, 0, &mesh, NULL) == BRITTLE_OK);
    brittle_mesh_free(mesh);
    CHECK(brittle_run_object_pieces(run, 1, &pieces, NULL) == BRITTLE_OK);
    brittle_pieces_free(pieces);
    CHECK(brittle_run_notes(run, &notes, NULL) == BRITTLE_OK && strcmp(brittle_text_get(notes), "") == 0);
    brittle_text_free(notes);
    CHECK(brittle_run_step(run, 30, NULL) == BRITTLE_OK);
    brittle_run_free(run);
}

static int record(const char* recipe_file, const char* log) {
    brittle_error error = {sizeof error, 0, ""};
    brittle_recipe* recipe = NULL;
    brittle_run* run = NULL;
    must(brittle_recipe_load(recipe_file, &recipe, &error), &error);
    must(brittle_run_start(recipe, NULL, &run, &error), &error);
    must(brittle_run_step(run, 10, &error), &error);
    must(brittle_run_act(run, shot, &error), &error);
    must(brittle_run_step(run, 50, &error), &error);
    must(brittle_run_save_log(run, log, &error), &error);
    brittle_run_free(run);
    brittle_recipe_free(recipe);
    return 0;
}

static int replay(const char* log) {
    brittle_error error = {sizeof error, 0, ""};
    brittle_replay_result result;
    memset(&result, 0, sizeof result);
    result.struct_size = sizeof result;
    must(brittle_replay(log, NULL, &result, &error), &error);
    printf("%llu steps, %s%s\n", (unsigned long long)result.steps,
           result.is_equal ? "all equal" : "different: ", result.difference);
    return result.is_equal ? 0 : 1;
}

static int print_hash(const char* recipe_file) {
    brittle_error error = {sizeof error, 0, ""};
    brittle_recipe* recipe = NULL;
    brittle_pieces* pieces = NULL;
    brittle_certificate certificate;
    memset(&certificate, 0, sizeof certificate);
    certificate.struct_size = sizeof certificate;
    must(brittle_recipe_load(recipe_file, &recipe, &error), &error);
    must(brittle_recipe_fracture(recipe, NULL, &pieces, &error), &error);
    must(brittle_pieces_certificate(pieces, &certificate, &error), &error);
    printf("hash %016llx\n", (unsigned long long)certificate.hash);
    brittle_pieces_free(pieces);
    brittle_recipe_free(recipe);
    return 0;
}

int main(int argc, char** argv) {
    if (argc == 3 && strcmp(argv[1], "--hash") == 0) return print_hash(argv[2]);
    if (argc == 4 && strcmp(argv[1], "--record") == 0) return record(argv[2], argv[3]);
    if (argc == 3 && strcmp(argv[1], "--replay") == 0) return replay(argv[2]);
    if (argc != 2) return 2;
    test_recipes(argv[1]);
    test_fractures();
    test_loose_pieces();
    test_blows(argv[1]);
    test_difference(argv[1]);
    test_other_pieces(argv[1]);
    test_scene();
    printf("%d checks, %d failed\n", checks, check_failures);
    return check_failures != 0;
}

#define CATCH_CONFIG_RUNNER // Catch2 2: its own code is compiled here
#include "catch.h"

int main(int argc, char **argv) {
    return Catch::Session().run(argc, argv);
}

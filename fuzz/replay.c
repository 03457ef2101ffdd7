/* Gives the files named as arguments to a fuzzing target, one after the other, without a fuzzer. */
#include "input.h"

int main(int count, char **name)
{
    static uint8_t data[1 << 20];
    for (int i = 1; i < count; i++) {
        FILE *file = fopen(name[i], "rb");
        REQUIRE(file);
        const size_t size = fread(data, 1, sizeof data, file);
        fclose(file);
        fprintf(stderr, "%s\n", name[i]); /* so that the last one named is the one that broke it */
        REQUIRE(LLVMFuzzerTestOneInput(data, size) == 0);
    }
    printf("%d inputs\n", count - 1);
    return 0;
}

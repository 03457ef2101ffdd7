/* Runs an FMU's library and prints all outputs of each step, as hexadecimal numbers:
 *
 *     cross_host LIBRARY RESOURCES GUID STEPS STEP REFERENCE...
 */
#include <fmi2FunctionTypes.h>
#include <stdio.h>
#include <stdlib.h>

#if defined(_WIN32)
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(library, name) (void *)GetProcAddress(library, name)
typedef HMODULE opened;
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
typedef void *opened;
#endif

static void check(int ok, const char *what)
{
    if (ok) return;
    fprintf(stderr, "failed: %s\n", what);
    exit(1);
}
#define OK(call) check((call) == fmi2OK, #call)
#define FUNCTION(name)                                                                             \
    fmi2##name##TYPE *name = (fmi2##name##TYPE *)FIND(library, "fmi2" #name);                      \
    check(name != NULL, #name)

static void to_stderr(void *environment, fmi2String instance, fmi2Status status,
                      fmi2String category, fmi2String format, ...)
{
    (void)environment;
    fprintf(stderr, "%s %d %s: %s\n", instance, status, category, format);
}

int main(int count, char **word)
{
    check(count > 6, "LIBRARY RESOURCES GUID STEPS STEP REFERENCE...");
    opened library = OPEN(word[1]);
    check(library != NULL, "the library cannot be loaded");
    FUNCTION(Instantiate);
    FUNCTION(SetupExperiment);
    FUNCTION(EnterInitializationMode);
    FUNCTION(ExitInitializationMode);
    FUNCTION(DoStep);
    FUNCTION(GetReal);
    FUNCTION(Terminate);
    FUNCTION(FreeInstance);
    const fmi2CallbackFunctions callbacks = {to_stderr, calloc, free, NULL, NULL};
    fmi2Component c =
        Instantiate("span", fmi2CoSimulation, word[3], word[2], &callbacks, fmi2False, fmi2True);
    check(c != NULL, "Instantiate");
    OK(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    OK(EnterInitializationMode(c));
    OK(ExitInitializationMode(c));
    const int steps = atoi(word[4]);
    const double step = atof(word[5]);
    for (int k = 0; k < steps; k++) {
        OK(DoStep(c, k * step, step, fmi2True));
        for (int i = 6; i < count; i++) {
            const fmi2ValueReference reference = (fmi2ValueReference)atoi(word[i]);
            double value;
            OK(GetReal(c, &reference, 1, &value));
            printf("%a%c", value, i + 1 < count ? ' ' : '\n');
        }
    }
    OK(Terminate(c));
    FreeInstance(c);
    return 0;
}

/* Compiled with -DFMI3, the sequences call the functions of FMI 3.0 under the names of FMI 2.0; the
 * few that differ in more than their arguments are in the files of the sequences. */
#ifndef FUZZING_AS_FMI3_H
#define FUZZING_AS_FMI3_H

#include "instance.h"

#include <fmi3Functions.h>

#define TIME_REFERENCE 0x7fffffffu

static inline void insist_on_plain_text(fmi3InstanceEnvironment environment, fmi3Status status,
                                        fmi3String category, fmi3String message)
{
    REQUIRE(category && status == fmi3Error && strlen(message) > 10);
    if (environment) ++*(long *)environment;
}

static inline fmi2Component instantiate_3(fmi2String name, fmi2Type type, fmi2String token,
                                          fmi2String location, const fmi2CallbackFunctions *call,
                                          bool visible, bool logging)
{
    fmi3LogMessageCallback log = call && call->logger ? insist_on_plain_text : NULL;
    void *environment = call ? call->componentEnvironment : NULL;
    if (type == fmi2ModelExchange)
        return fmi3InstantiateModelExchange(name, token, location, visible, logging, environment,
                                            log);
    return fmi3InstantiateCoSimulation(name, token, location, visible, logging, false, visible,
                                       NULL, 0, environment, log, NULL);
}

/* Whole numbers through 64 bits if there are two of them, which is another way for them. */
static inline fmi2Status get_whole_3(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                     fmi2Integer value[])
{
    fmi3Int64 wide[2] = {0, 0};
    if (count != 2) return (fmi2Status)fmi3GetInt32(c, r, count, value, count);
    const fmi3Status status = fmi3GetInt64(c, r, count, wide, count);
    for (int i = 0; status == fmi3OK && i < 2; i++) value[i] = (fmi2Integer)wide[i];
    return (fmi2Status)status;
}

static inline fmi2Status set_whole_3(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                     const fmi2Integer value[])
{
    if (count != 2) return (fmi2Status)fmi3SetInt32(c, r, count, value, count);
    const fmi3Int64 wide[2] = {value[0], value[1]};
    return (fmi2Status)fmi3SetInt64(c, r, count, wide, count);
}

#undef fmi2Instantiate
#undef fmi2GetInteger
#undef fmi2SetInteger
#undef fmi2FreeInstance
#undef fmi2EnterInitializationMode
#undef fmi2ExitInitializationMode
#undef fmi2Terminate
#undef fmi2Reset
#undef fmi2DoStep
#undef fmi2GetReal
#undef fmi2SetReal
#undef fmi2GetRealStatus
#undef fmi2GetRealOutputDerivatives
#undef fmi2GetDirectionalDerivative
#undef fmi2GetFMUstate
#undef fmi2SetFMUstate
#undef fmi2FreeFMUstate
#undef fmi2SerializedFMUstateSize
#undef fmi2SerializeFMUstate
#undef fmi2DeSerializeFMUstate

#define fmi2Instantiate instantiate_3
#define fmi2GetInteger get_whole_3
#define fmi2SetInteger set_whole_3
#define fmi2FreeInstance fmi3FreeInstance
#define fmi2EnterInitializationMode(c)                                                             \
    (fmi2Status)                                                                                   \
        fmi3EnterInitializationMode(c, false, 0.0, s->is.time, isfinite(s->is.stop), s->is.stop)
#define fmi2ExitInitializationMode(c) (fmi2Status) fmi3ExitInitializationMode(c)
#define fmi2Terminate(c) (fmi2Status) fmi3Terminate(c)
#define fmi2Reset(c) (fmi2Status) fmi3Reset(c)
#define fmi2DoStep(c, time, h, no_return)                                                          \
    (fmi2Status) fmi3DoStep(c, time, h, no_return, NULL, NULL, NULL, NULL)
#define fmi2GetReal(c, r, n, v) (fmi2Status) fmi3GetFloat64(c, r, n, v, n)
#define fmi2SetReal(c, r, n, v) (fmi2Status) fmi3SetFloat64(c, r, n, v, n)
#define fmi2GetRealStatus(c, kind, v)                                                              \
    (fmi2Status) fmi3GetFloat64(c, &(fmi3ValueReference){TIME_REFERENCE}, 1, v, 1)
#define fmi2GetRealOutputDerivatives(c, r, n, o, v)                                                \
    (fmi2Status) fmi3GetOutputDerivatives(c, r, n, o, v, n)
#define fmi2GetDirectionalDerivative(c, u, nu, k, nk, s, d)                                        \
    (fmi2Status) fmi3GetDirectionalDerivative(c, u, nu, k, nk, s, nk, d, nu)
#define fmi2GetFMUstate(c, state) (fmi2Status) fmi3GetFMUState(c, state)
#define fmi2SetFMUstate(c, state) (fmi2Status) fmi3SetFMUState(c, state)
#define fmi2FreeFMUstate(c, state) (fmi2Status) fmi3FreeFMUState(c, state)
#define fmi2SerializedFMUstateSize(c, state, size)                                                 \
    (fmi2Status) fmi3SerializedFMUStateSize(c, state, size)
#define fmi2SerializeFMUstate(c, state, bytes, size)                                               \
    (fmi2Status) fmi3SerializeFMUState(c, state, (fmi3Byte *)(bytes), size)
#define fmi2DeSerializeFMUstate(c, bytes, size, state)                                             \
    (fmi2Status) fmi3DeserializeFMUState(c, (const fmi3Byte *)(bytes), size, state)

#endif

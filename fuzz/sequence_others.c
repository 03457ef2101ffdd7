/* Calls of what one version of FMI has and this FMU has not. */
#include "sequence.h"

#if defined(FMI3)

void others(slot *s, uint8_t what)
{
    const fmi3ValueReference r[2] = {0, 8};
    const fmi3String category[] = {byte() % 2 ? "logStatusError" : "nonsense"};
    fmi3Boolean truth[1] = {false};
    fmi3Float64 real[2] = {0.0, 0.0};
    fmi3Int64 wide[1] = {(fmi3Int64)1 << 40};
    size_t size[1];
    fmi2Status status;
    fmi3Instance c = s->c;
    switch (what) {
    case 0: JUDGE(s, REFUSED, true, (fmi2Status)fmi3EnterEventMode(c)); break;
    case 1: JUDGE(s, REFUSED, true, (fmi2Status)fmi3EnterStepMode(c)); break;
    case 2: JUDGE(s, REFUSED, true, (fmi2Status)fmi3GetFloat64(c, r, 1, real, 2)); break;
    case 3: JUDGE(s, REFUSED, true, (fmi2Status)fmi3SetFloat64(c, r, 2, real, 1)); break;
    case 4: JUDGE(s, REFUSED, true, (fmi2Status)fmi3SetInt64(c, r, 1, wide, 1)); break;
    case 5: JUDGE(s, REFUSED, true, (fmi2Status)fmi3GetInt64(c, r, 1, NULL, 1)); break;
    case 6: JUDGE(s, REFUSED, true, (fmi2Status)fmi3GetBoolean(c, r, 1, truth, 1)); break;
    case 7: JUDGE(s, REFUSED, true, (fmi2Status)fmi3GetClock(c, r, 1, truth)); break;
    case 8:
        JUDGE(s, REFUSED, true, (fmi2Status)fmi3GetNumberOfVariableDependencies(c, r[1], size));
        break;
    case 9: JUDGE(s, REFUSED, true, (fmi2Status)fmi3EnterConfigurationMode(c)); break;
    case 10: JUDGE(s, when(s, ANY), true, (fmi2Status)fmi3GetInt64(c, NULL, 0, NULL, 0)); break;
    default:
        JUDGE(s, category[0][0] == 'l' ? when(s, ANY) : REFUSED, true,
              (fmi2Status)fmi3SetDebugLogging(c, true, 1, category));
    }
}

#else

void others(slot *s, uint8_t what)
{
    const fmi2ValueReference r[1] = {0};
    const fmi2String category[] = {byte() % 2 ? "logStatusError" : "nonsense"};
    const verdict known = s->is.mode & (STEPPING | TERMINATED) ? ACCEPTED : REFUSED;
    fmi2Boolean truth[1] = {0};
    fmi2String text[1] = {""};
    fmi2Status status, given;
    fmi2Integer integer;
    fmi2Real real;
    const fmi2StatusKind kind = (fmi2StatusKind)(byte() % 4);
    switch (what) {
    case 0: JUDGE(s, REFUSED, true, fmi2CancelStep(s->c)); break;
    case 1: JUDGE(s, REFUSED, true, fmi2GetStatus(s->c, kind, &given)); break;
    case 2:
        JUDGE(s, kind == fmi2LastSuccessfulTime ? known : REFUSED, true,
              fmi2GetRealStatus(s->c, kind, &real));
        break;
    case 3: JUDGE(s, REFUSED, true, fmi2GetIntegerStatus(s->c, kind, &integer)); break;
    case 4:
        JUDGE(s, kind == fmi2Terminated ? known : REFUSED, true,
              fmi2GetBooleanStatus(s->c, kind, truth));
        break;
    case 5: JUDGE(s, REFUSED, true, fmi2GetStringStatus(s->c, kind, text)); break;
    case 6: JUDGE(s, REFUSED, true, fmi2SetBoolean(s->c, r, 1, truth)); break;
    case 7: JUDGE(s, REFUSED, true, fmi2GetBoolean(s->c, r, 1, truth)); break;
    case 8: JUDGE(s, REFUSED, true, fmi2SetString(s->c, r, 1, text)); break;
    case 9: JUDGE(s, REFUSED, true, fmi2GetString(s->c, r, 1, text)); break;
    case 10: JUDGE(s, when(s, ANY), true, fmi2GetString(s->c, NULL, 0, NULL)); break;
    default:
        JUDGE(s, category[0][0] == 'l' ? when(s, ANY) : REFUSED, true,
              fmi2SetDebugLogging(s->c, fmi2True, 1, category));
    }
}

#endif

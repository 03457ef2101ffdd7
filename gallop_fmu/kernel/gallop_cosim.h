/* Co-simulation of a span or line: the state machine that every run-time of an FMU uses.
 *
 * An instance is created from the content of a resource file (resources/model.bin of an FMU, see
 * resource.h), which holds the scene, the table of variables and the texts of failures.  Variables
 * are addressed by value reference: the index in that table.  Phases follow one another:
 *
 *     created -> gallop_cosim_enter_initialization -> gallop_cosim_exit_initialization -> stepping
 *             -> gallop_cosim_terminate; gallop_cosim_reset returns to the first from everywhere
 *
 * Between the steps, the wind and the attack angle hold their values over a communication step,
 * or change at the rate that gallop_cosim_set_input_rates gives; the tower points move linearly to
 * their new places, which they reach at the end of the step.  With an input of their velocity, that
 * place is the given one plus velocity times step.  In the time T of a longer step before, measured
 * from its end, they go on at the velocity v that the last steps show, or that the host gives; what
 * is missing to the new place takes the rest of T: they move at v + r / T, where v h + r is the way
 * to the place, and v changes by r h / T^2.  A way that belongs to the longer step, as one from a
 * host that is a step late, thus needs no velocity without bound.
 *
 * Rules: an instance may be used by one thread at a time, different instances by any number of
 * threads.  No globals, no printing.  Memory is allocated when an instance is created, by the first
 * call that needs a state after a parameter was changed, and by the functions for saved states.
 * Pointers to instances and saved states must come from the functions below and not be freed yet;
 * a null pointer is refused.  Arrays must have the lengths that their counts give.  The processor
 * must round to nearest, its default.  Units are those of the variables: SI and radians.
 */
#ifndef GALLOP_COSIM_H
#define GALLOP_COSIM_H

#include "gallop.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How a call ended.  Where it is not GALLOP_COSIM_OK, gallop_cosim_message says why. */
typedef enum {
    GALLOP_COSIM_OK = 0,
    GALLOP_COSIM_WARNING = 1, /* carried out, with a remark; no function returns it yet */
    GALLOP_COSIM_REFUSED = 2, /* the call or a value is not allowed; nothing was changed */
    GALLOP_COSIM_FAILED = 3 /* allowed, but it could not be carried out (no convergence, no memory);
                               but for the variable `status`, the instance is what it was before */
} gallop_cosim_status;

typedef struct gallop_cosim gallop_cosim;             /* one instance */
typedef struct gallop_cosim_saved gallop_cosim_saved; /* a saved state */

/* Value reference of the time that has been reached [s], a Real that can be read in every phase. It
 * is no variable of the table. */
#define GALLOP_COSIM_TIME 0x7fffffffu

/* Room that a message needs, its final 0 included. */
#define GALLOP_COSIM_MESSAGE_SIZE 1024

/* Completes the header of a resource file: magic, format, size and checksum.
 *
 * @param resource      The file, with the number of its sections, its directory and its sections
 *                      (resource_file.h)
 * @param size          Its bytes
 * @return              GALLOP_COMPLETED; GALLOP_BAD_CALL if it is NULL or has no room for a header
 */
GALLOP_API int gallop_cosim_seal(void *resource, size_t size);

/* Creates an instance in its first phase, with the parameters and inputs of the resource.
 *
 * @param resource      Content of the resource file; it is copied, and need not be aligned
 * @param size          Its bytes
 * @param identity      GUID that the resource must have; a text, not NULL
 * @param message       Where to write why it failed, GALLOP_COSIM_MESSAGE_SIZE bytes; may be NULL
 * @return              The instance, for gallop_cosim_free; NULL if the resource is damaged or of
 *                      another identity, the processor's arithmetic is not as needed, or there is
 *                      not enough memory
 */
GALLOP_API gallop_cosim *gallop_cosim_create(const void *resource, size_t size,
                                             const char *identity, char *message);

/* Frees an instance; NULL is ignored.  Saved states stay valid. */
GALLOP_API void gallop_cosim_free(gallop_cosim *instance);

/* Why the last call on this instance did not return GALLOP_COSIM_OK: the fact, then the remedy.
 *
 * @param instance      The instance; NULL gives a text that says so
 * @return              UTF-8, valid until the next call on the instance; "" if no call failed yet
 */
GALLOP_API const char *gallop_cosim_message(const gallop_cosim *instance);

/* Returns to the state after creation: parameters and inputs of the resource, first phase.
 *
 * @param instance      The instance, in any phase
 */
GALLOP_API gallop_cosim_status gallop_cosim_reset(gallop_cosim *instance);

/* Sets the time at which the run begins, and where it must end.  Without this call: 0, and no end.
 *
 * @param instance      The instance, before initialization
 * @param start         Start time [s]; finite
 * @param stop          No step may end after it [s]; greater than `start`, or infinite
 */
GALLOP_API gallop_cosim_status gallop_cosim_set_up(gallop_cosim *instance, double start,
                                                   double stop);

/* Begins initialization: from here on outputs can be read, and follow parameters and inputs.
 *
 * @param instance      The instance, before initialization
 */
GALLOP_API gallop_cosim_status gallop_cosim_enter_initialization(gallop_cosim *instance);

/* Ends initialization: computes the initial state, fixes the parameters, and allows steps.
 *
 * @param instance      The instance, in initialization; it stays there if there is no initial state
 */
GALLOP_API gallop_cosim_status gallop_cosim_exit_initialization(gallop_cosim *instance);

/* Advances by one communication step.  If it fails, the state is what it was before.
 *
 * @param instance      The instance, while stepping
 * @param time          Where the step begins [s]: the end of the last one, up to 1e-6 of the step
 * @param step          Its size [s]; greater than 0, at most 1e6, and not lost in round-off
 */
GALLOP_API gallop_cosim_status gallop_cosim_step(gallop_cosim *instance, double time, double step);

/* Ends the run; outputs can still be read.
 *
 * @param instance      The instance, while stepping
 */
GALLOP_API gallop_cosim_status gallop_cosim_terminate(gallop_cosim *instance);

/* Reads the time that has been reached.
 *
 * @param instance      The instance, while stepping or after termination
 * @param time          Where to write the end of the last completed step [s]
 */
GALLOP_API gallop_cosim_status gallop_cosim_time(gallop_cosim *instance, double *time);

/* Reads Real variables.  Parameters and inputs can be read in every phase, outputs from
 * initialization on; in initialization this may compute the initial state.
 *
 * @param instance      The instance
 * @param reference     Value references of Reals
 * @param count         How many
 * @param value         Where to write the values; on failure some of them may have been written
 */
GALLOP_API gallop_cosim_status gallop_cosim_get_real(gallop_cosim *instance,
                                                     const uint32_t reference[], size_t count,
                                                     double value[]);

/* Reads Integer variables, as gallop_cosim_get_real does Reals. */
GALLOP_API gallop_cosim_status gallop_cosim_get_integer(gallop_cosim *instance,
                                                        const uint32_t reference[], size_t count,
                                                        int32_t value[]);

/* Sets Real variables: all of them or, if one is refused, none.
 *
 * @param instance      The instance, before termination; parameters only until initialization ends
 * @param reference     Value references of Real parameters and inputs
 * @param count         How many
 * @param value         Their values; finite and within the bounds of the variable
 */
GALLOP_API gallop_cosim_status gallop_cosim_set_real(gallop_cosim *instance,
                                                     const uint32_t reference[], size_t count,
                                                     const double value[]);

/* Sets Integer variables, as gallop_cosim_set_real does Reals. */
GALLOP_API gallop_cosim_status gallop_cosim_set_integer(gallop_cosim *instance,
                                                        const uint32_t reference[], size_t count,
                                                        const int32_t value[]);

/* Sets the time derivatives of inputs during the next step: all of them or none.  Afterwards they
 * are 0.  A wind speed that would change its sign within the step becomes 0 at its end.
 *
 * @param instance      The instance, before termination
 * @param reference     Value references of inputs
 * @param count         How many
 * @param rate          Their derivatives, unit of the input per second; finite
 */
GALLOP_API gallop_cosim_status gallop_cosim_set_input_rates(gallop_cosim *instance,
                                                            const uint32_t reference[],
                                                            size_t count, const double rate[]);

/* Reads the time derivatives of outputs: exact for motions, whose derivative is another output or
 * the acceleration; for forces, tension and angle the difference over the last step (0 before the
 * first one).
 *
 * @param instance      The instance, while stepping or after termination.  For differences, the
 *                      last call of gallop_cosim_step must have succeeded
 * @param reference     Value references of Real outputs
 * @param count         How many
 * @param rate          Where to write the derivatives, unit of the output per second
 */
GALLOP_API gallop_cosim_status gallop_cosim_get_output_rates(gallop_cosim *instance,
                                                             const uint32_t reference[],
                                                             size_t count, double rate[]);

/* Computes the derivative of outputs at the end of the last step by the inputs of that step, in the
 * direction of `seed`; in initialization and before the first step, of the initial state by its
 * inputs.  Costs two repetitions of the step.
 *
 * @param instance      The instance, from initialization on; the last step as for
 *                      gallop_cosim_get_output_rates
 * @param output        Value references of Real outputs
 * @param outputs       How many
 * @param input         Value references of inputs
 * @param inputs        How many
 * @param seed          Direction: one finite number for each input, in its unit
 * @param derivative    Where to write the derivatives, one for each output
 */
GALLOP_API gallop_cosim_status gallop_cosim_directional_derivative(
    gallop_cosim *instance, const uint32_t output[], size_t outputs, const uint32_t input[],
    size_t inputs, const double seed[], double derivative[]);

/* Saves all that the future of an instance depends on.
 *
 * @param instance      The instance, in any phase
 * @param saved         Where the saved state is; it is written over if it points to one that was
 *                      saved before, and allocated if it points to NULL
 */
GALLOP_API gallop_cosim_status gallop_cosim_save(gallop_cosim *instance,
                                                 gallop_cosim_saved **saved);

/* Returns to a saved state, bit for bit.
 *
 * @param instance      The instance, in any phase
 * @param saved         A state that was saved by an instance of the same resource
 */
GALLOP_API gallop_cosim_status gallop_cosim_restore(gallop_cosim *instance,
                                                    const gallop_cosim_saved *saved);

/* Frees a saved state; NULL is ignored. */
GALLOP_API void gallop_cosim_free_saved(gallop_cosim_saved *saved);

/* Number of bytes that gallop_cosim_serialize writes.
 *
 * @param instance      An instance, which holds the message if this fails
 * @param saved         The saved state
 * @param size          Where to write the number
 */
GALLOP_API gallop_cosim_status gallop_cosim_serialized_size(gallop_cosim *instance,
                                                            const gallop_cosim_saved *saved,
                                                            size_t *size);

/* Writes a saved state as bytes, with a checksum; equal states give equal bytes.  They can be read
 * by this version of the library, on processors with the same order of bytes.
 *
 * @param instance      An instance, which holds the message if this fails
 * @param saved         The saved state
 * @param bytes         Where to write it
 * @param size          How many bytes there is room for
 */
GALLOP_API gallop_cosim_status gallop_cosim_serialize(gallop_cosim *instance,
                                                      const gallop_cosim_saved *saved, void *bytes,
                                                      size_t size);

/* Reads a saved state from bytes.  Every value in them is checked, even if the checksum matches:
 * here, and when the state is restored.
 *
 * @param instance      An instance of the resource that the state belongs to
 * @param bytes         What gallop_cosim_serialize wrote; it need not be aligned
 * @param size          How many bytes
 * @param saved         Where to write the state, which the caller frees; untouched on failure
 */
GALLOP_API gallop_cosim_status gallop_cosim_deserialize(gallop_cosim *instance, const void *bytes,
                                                        size_t size, gallop_cosim_saved **saved);

#ifdef __cplusplus
}
#endif
#endif

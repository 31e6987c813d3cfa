/* Every function that more than one file uses carries the model's name in front, so that several FMUs can be linked into
 * one program; what only one file uses is static.  tests/native/test_static_linking.py reads the symbols. */
#ifndef PSP_NAMES_H
#define PSP_NAMES_H

#include "psp_prefix.h" /* written with the FMU: PSP_PREFIX */

#define PSP_JOINED(prefix, name) prefix##name
#define PSP_JOIN(prefix, name) PSP_JOINED(prefix, name)
#define PSP_NAME(name) PSP_JOIN(PSP_PREFIX, name)

/* the front */
#define front_log PSP_NAME(front_log)
#define front_log_list PSP_NAME(front_log_list)
#define front_print PSP_NAME(front_print)
#define front_enter PSP_NAME(front_enter)
#define front_judge PSP_NAME(front_judge)
#define front_leave PSP_NAME(front_leave)
#define front_failure PSP_NAME(front_failure)
#define front_has PSP_NAME(front_has)
#define front_fail PSP_NAME(front_fail)
#define front_call_name PSP_NAME(front_call_name)
#define front_choose_categories PSP_NAME(front_choose_categories)
#define front_free_states PSP_NAME(front_free_states)
#define front_refuse_state PSP_NAME(front_refuse_state)
#define front_hash PSP_NAME(front_hash)
#define text_is_utf8 PSP_NAME(text_is_utf8)
#define text_for_logger PSP_NAME(text_for_logger)
#define text_excerpt PSP_NAME(text_excerpt)
#define resource_path PSP_NAME(resource_path)

/* a backend */
#define backend_guid PSP_NAME(backend_guid)
#define backend_new PSP_NAME(backend_new)
#define backend_free PSP_NAME(backend_free)
#define backend_setup PSP_NAME(backend_setup)
#define backend_enter_initialization PSP_NAME(backend_enter_initialization)
#define backend_exit_initialization PSP_NAME(backend_exit_initialization)
#define backend_terminate PSP_NAME(backend_terminate)
#define backend_reset PSP_NAME(backend_reset)
#define backend_do_step PSP_NAME(backend_do_step)
#define backend_get_real PSP_NAME(backend_get_real)
#define backend_get_integer PSP_NAME(backend_get_integer)
#define backend_get_boolean PSP_NAME(backend_get_boolean)
#define backend_get_string PSP_NAME(backend_get_string)
#define backend_set_real PSP_NAME(backend_set_real)
#define backend_set_integer PSP_NAME(backend_set_integer)
#define backend_set_boolean PSP_NAME(backend_set_boolean)
#define backend_set_string PSP_NAME(backend_set_string)
#define backend_get_state PSP_NAME(backend_get_state)
#define backend_set_state PSP_NAME(backend_set_state)
#define backend_free_state PSP_NAME(backend_free_state)
#define backend_state_size PSP_NAME(backend_state_size)
#define backend_write_state PSP_NAME(backend_write_state)
#define backend_read_state PSP_NAME(backend_read_state)
#define backend_directional_derivative PSP_NAME(backend_directional_derivative)

/* the backend of the Python FMU */
#define library_open PSP_NAME(library_open)
#define library_function PSP_NAME(library_function)
#define library_error PSP_NAME(library_error)
#define python_is_running PSP_NAME(python_is_running)

/* native FMUs */
#define native_make_ready PSP_NAME(native_make_ready)
#define native_start_values PSP_NAME(native_start_values)
#define part_initialise PSP_NAME(part_initialise)
#define part_changed PSP_NAME(part_changed)
#define part_put_out PSP_NAME(part_put_out)
#define part_restore PSP_NAME(part_restore)
#define state_is_flag PSP_NAME(state_is_flag)
#define state_is_count PSP_NAME(state_is_count)
#define state_is_shape PSP_NAME(state_is_shape)
#define feedback PSP_NAME(feedback)
#define largest_period PSP_NAME(largest_period)
#define pass_time PSP_NAME(pass_time)
#define locate PSP_NAME(locate)
#define printable PSP_NAME(printable)
#define finite_or_log PSP_NAME(finite_or_log)
#define read_choice PSP_NAME(read_choice)
#define read_period PSP_NAME(read_period)
#define read_constants PSP_NAME(read_constants)
#define read_weights PSP_NAME(read_weights)
#define read_request PSP_NAME(read_request)
#define require_feasible PSP_NAME(require_feasible)
#define project PSP_NAME(project)
#define network_for PSP_NAME(network_for)
#define network_candidates PSP_NAME(network_candidates)
#define outside_domain PSP_NAME(outside_domain)
#define choose_shape PSP_NAME(choose_shape)
#define warn_of_fallback PSP_NAME(warn_of_fallback)
#define PSP_VARIABLE_NAMES PSP_NAME(VARIABLE_NAMES)

/* the closed loop */
#define platoon_read PSP_NAME(platoon_read)
#define platoon_sample PSP_NAME(platoon_sample)
#define platoon_advance PSP_NAME(platoon_advance)
#define platoon_observe PSP_NAME(platoon_observe)
#define platoon_log_violation PSP_NAME(platoon_log_violation)
#define platoon_tangent PSP_NAME(platoon_tangent)
#define part_begin PSP_NAME(part_begin)
#define part_make_changes PSP_NAME(part_make_changes)
#define trial_choose PSP_NAME(trial_choose)
#define trial_join PSP_NAME(trial_join)
#define trial_find_gap PSP_NAME(trial_find_gap)
#define trial_take_out PSP_NAME(trial_take_out)

/* the controller */
#define read_settings PSP_NAME(read_settings)
#define nothing_decided PSP_NAME(nothing_decided)
#define decide PSP_NAME(decide)

#endif

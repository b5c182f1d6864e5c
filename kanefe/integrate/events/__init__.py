"""Events of a run: functions whose zeros are searched for, and what is done there."""

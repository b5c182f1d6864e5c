"""Impacts of rigid contacts, and which of them are open, stick and slip after an event, in compiled code."""

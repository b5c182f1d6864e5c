"""Forces and impacts of rigid contacts by the literal route."""
